"""Runs any Python script in bpy with the Sinew extension, built from these sources, installed and enabled.

usage: python3 scripts/run_in_blender.py [--blender 5.2|4.5] SCRIPT [ARG...]

The script runs as __main__ in the current folder, with sys.argv = [SCRIPT, ARG...], and its exit code is passed on.
Environments and the extension are built first if necessary, with progress on stderr; standard output holds only the script's
output. Exit code 125 means that the script was not started, because something is missing or does not build.
"""

import argparse
import sys
from pathlib import Path

from build import blender, environment
from build.console import Failure

NOT_STARTED = 125


def main() -> int:
    about, _, usage = __doc__.partition("\n\n")
    parser = argparse.ArgumentParser(description=about, epilog=usage, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--blender", choices=environment.BLENDERS, default=environment.BLENDERS[0])
    parser.add_argument("script", metavar="SCRIPT")
    parser.add_argument("arguments", metavar="ARG", nargs=argparse.REMAINDER)
    wanted = parser.parse_args()
    if not Path(wanted.script).is_file():
        parser.error(f"there is no script {wanted.script}")
    try:
        return blender.run(wanted.blender, wanted.script, wanted.arguments)
    except Failure as error:
        print(f"sinew: {error}", file=sys.stderr)
        return NOT_STARTED


if __name__ == "__main__":
    sys.exit(main())
