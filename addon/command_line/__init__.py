# SPDX-License-Identifier: GPL-3.0-or-later
"""The command line `blender --command sinew VERB ...`: bakes, merges, measures and adds presets without a window."""

import argparse
import traceback

import bpy

from ..errors import SinewError
from ..files.atomic_write import NotWritten
from . import bake, measure, merge, preset
from .output import Reporter, WrongArguments

DONE, FAULT, BAD_USAGE, BAD_INPUT, NOT_WRITTEN, INTERRUPTED = 0, 1, 2, 3, 4, 130
NAME = "sinew"
_VERBS = {"bake": bake, "merge": merge, "measure": measure, "preset": preset}
_EPILOG = """\
exit codes: 0 done; 1 an internal error; 2 wrong arguments; 3 bad input: a file, object or frame that is not there or
can't be used; 4 a file could not be written (what was there before still is); 130 interrupted

Progress and messages go to standard error. Blender itself writes to standard output, where the result of --json is the
only line that begins with {. Start Blender with -y (blender -y --command sinew ...) for files whose drivers need Python.
"""


def run(arguments: list[str]) -> int:
    """Runs a command line, given without the program's name, and returns the exit code. Never raises."""
    try:
        options = _parser().parse_args(arguments)
    except SystemExit as ending:  # argparse has printed an error or its help
        return ending.code if isinstance(ending.code, int) else BAD_USAGE
    reporter = Reporter(options.json, options.report)
    try:
        reporter.result(options.run(options, reporter))
        return DONE
    except NotWritten as error:
        return reporter.failure(str(error), NOT_WRITTEN)
    except WrongArguments as error:
        return reporter.failure(str(error), BAD_USAGE)
    except SinewError as error:
        return reporter.failure(str(error), BAD_INPUT)
    except KeyboardInterrupt:
        return reporter.failure("interrupted", INTERRUPTED)
    except Exception as error:
        traceback.print_exc()
        return reporter.failure(f"an internal error: {error!r}", FAULT)


def _parser() -> argparse.ArgumentParser:
    formatter = argparse.RawDescriptionHelpFormatter
    parser = argparse.ArgumentParser(
        prog=f"blender --command {NAME}",
        description="Muscles for Blender characters.",
        epilog=_EPILOG,
        formatter_class=formatter,
    )
    verbs = parser.add_subparsers(metavar="VERB", required=True)
    for name, verb in _VERBS.items():
        summary, _, details = (verb.__doc__ or "").partition("\n\n")
        verb_parser = verbs.add_parser(name, help=summary, description=summary, epilog=details, formatter_class=formatter)
        verb.add_arguments(verb_parser)
        verb_parser.add_argument("--json", action="store_true", help="print the result as a line of JSON on standard output")
        verb_parser.add_argument("--report", metavar="FILE", help="write the result as JSON to this file")
        verb_parser.set_defaults(run=verb.run)
    return parser


_registered = None


def register():
    global _registered
    _registered = bpy.utils.register_cli_command(NAME, run)


def unregister():
    global _registered
    bpy.utils.unregister_cli_command(_registered)
    _registered = None
