"""Stands in for a Blender program where there is only the bpy module, which has no command line: for tests of farms.

usage: python3 scripts/run_in_blender.py scripts/build/command_in_blender.py [-b] [-y] [FILE] --command sinew VERB ...

Takes these arguments as Blender's program does, opens FILE, and ends with what Sinew's own handler returns.
"""

import sys

import bpy
from bl_ext.user_default.sinew import command_line


def main(arguments: list[str]) -> int:
    """Runs a command line without the program's name; returns the exit code."""
    if "--command" not in arguments:
        sys.exit("only --command can be used here")
    at = arguments.index("--command")
    if arguments[at + 1 : at + 2] != [command_line.NAME]:
        sys.exit(f"only --command {command_line.NAME} can be used here")
    for argument in arguments[:at]:
        if argument not in ("-b", "--background", "-y", "--enable-autoexec"):
            bpy.ops.wm.open_mainfile(filepath=argument)
    return command_line.run(arguments[at + 2 :])


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
