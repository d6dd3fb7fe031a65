"""Replaces the Blender program in tests of render farms, because the bpy module has no command line.

usage: python3 scripts/run_in_blender.py scripts/build/command_in_blender.py [-b] [-y] [FILE] --command sinew VERB ...

It takes the arguments of the Blender program, opens FILE, and exits with the code that Sinew's handler returns.
"""

import sys

import bpy
from bl_ext.user_default.sinew import command_line


def main(arguments: list[str]) -> int:
    """Runs a command line, given without the program's name; returns the exit code."""
    if "--command" not in arguments:
        sys.exit("Only --command works here")
    at = arguments.index("--command")
    if arguments[at + 1 : at + 2] != [command_line.NAME]:
        sys.exit(f"Only --command {command_line.NAME} works here")
    for argument in arguments[:at]:
        if argument not in ("-b", "--background", "-y", "--enable-autoexec"):
            bpy.ops.wm.open_mainfile(filepath=argument)
    return command_line.run(arguments[at + 2 :])


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
