"""Draws the figures of docs/mathematics.

usage: python3 scripts/figure_mathematics.py [NAME ...]        (without a name: all figures)

Runs scripts/pictures/mathematics/drawings.py in the Python environment of Blender 5.2, which has numpy and matplotlib, with
the Rust core of these sources. It does not use Blender itself.
"""

import argparse
import os
import subprocess
import sys
import tempfile
import zipfile

from build import environment
from build import wheel as build_wheel
from build.console import Failure
from build.layout import SCRIPTS


def main() -> int:
    parser = argparse.ArgumentParser(description="Draws the figures of docs/mathematics.")
    parser.add_argument("names", nargs="*", metavar="NAME", help="draw only these, such as belly or bend")
    wanted = parser.parse_args()
    try:
        python, wheel = environment.blender(environment.BLENDERS[0]), build_wheel.build()
    except Failure as error:
        print(f"sinew: {error}", file=sys.stderr)
        return 1
    with tempfile.TemporaryDirectory() as folder:
        zipfile.ZipFile(wheel).extractall(folder)
        command = [str(python), str(SCRIPTS / "pictures/mathematics/drawings.py"), *wanted.names]
        return subprocess.run(command, env=os.environ | {"PYTHONPATH": folder}).returncode


if __name__ == "__main__":
    sys.exit(main())
