"""Runs a script in this process's bpy as if Python had started it, with the Sinew extension enabled.

usage: (a Python with bpy) inside_blender.py SCRIPT [ARG...]

Scripts use factory resets to start from an empty file, and a reset disables add-ons. A user's preferences would enable Sinew
again, so this module enables it before the reset returns.
"""

import atexit
import faulthandler
import os
import sys
import traceback
import types
from pathlib import Path

import bpy
import addon_utils  # Blender's own module; it can be imported after bpy
from bpy.app.handlers import persistent

EXTENSION = "bl_ext.user_default.sinew"
SCRIPTS = Path(__file__).resolve().parents[1]


@persistent
def enable_extension(*_):
    """Enables the extension, with its wheels, unless it is enabled."""
    if addon_utils.check(EXTENSION) != (True, True):
        addon_utils.enable(EXTENSION, default_set=True)


def keep_extension_enabled():
    """Enables the extension now and after every reset; returns whether it could be enabled."""
    enable_extension()
    if addon_utils.check(EXTENSION) != (True, True):
        return False
    for handlers in (
        bpy.app.handlers.load_factory_preferences_post,
        bpy.app.handlers.load_factory_startup_post,
        bpy.app.handlers.load_post,
    ):
        handlers.append(enable_extension)
    return True


def run_as_main(script, arguments):
    """Runs a script's source as the module __main__; returns the argument of its SystemExit, or an exit code."""
    path = Path(script)
    module = types.ModuleType("__main__")
    module.__file__ = script
    module.__dict__["__cached__"] = None
    sys.modules["__main__"] = module
    sys.argv = [script, *arguments]
    folder_of_this_file = str(Path(__file__).parent)  # Python added it first, and bpy added its folder before it
    sys.path[:] = [str(path.resolve().parent), *(folder for folder in sys.path if folder != folder_of_this_file)]
    if SCRIPTS in path.resolve().parents:
        sys.path.append(str(SCRIPTS))  # scripts of this repository import each other
    try:
        exec(compile(path.read_bytes(), script, "exec"), module.__dict__)
    except SystemExit as ending:
        return ending.code
    except BaseException as error:
        error.__traceback__ = error.__traceback__ and error.__traceback__.tb_next  # without the frame of this file
        traceback.print_exception(error)
        return 130 if isinstance(error, KeyboardInterrupt) else 1
    return 0


def end_without_teardown(exit_code):
    """Ends the process once Python has ended its threads and run its exit functions.

    After that, Python would tear down bpy, which can hang (4.5) and prints messages about leaked memory.
    """
    sys.stdout.flush()
    sys.stderr.flush()
    os._exit(exit_code)


def exit_code_of(ending):
    """The exit code that Python gives to `SystemExit(ending)`. Prints `ending` if it is a text."""
    if ending is None or isinstance(ending, int):
        return (ending or 0) & 0xFF
    print(ending, file=sys.stderr)
    return 1


def main():
    if not keep_extension_enabled():
        return exit_code_of(f"{EXTENSION} could not be enabled")
    return exit_code_of(run_as_main(sys.argv[1], sys.argv[2:]))


if __name__ == "__main__":
    faulthandler.enable()
    atexit.register(lambda: end_without_teardown(code))
    code = 1
    code = main()
