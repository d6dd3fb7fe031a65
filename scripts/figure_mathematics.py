"""Draws the figures of docs/mathematics.

usage: python3 scripts/figure_mathematics.py [NAME ...]        (all of them where none is named)

Runs figure_drawings.py in the Python environment of Blender 5.2 (numpy, matplotlib) with the Rust core of these sources.
Blender itself is not used.
"""

import argparse
import os
import subprocess
import sys
import tempfile
import zipfile

import build_wheel
import environment
from console import Failure
from layout import SCRIPTS


def main() -> int:
    parser = argparse.ArgumentParser(description="Draws the figures of docs/mathematics.")
    parser.add_argument("names", nargs="*", metavar="NAME", help="these alone, such as belly or bend")
    wanted = parser.parse_args()
    try:
        python, wheel = environment.blender(environment.BLENDERS[0]), build_wheel.build()
    except Failure as error:
        print(f"sinew: {error}", file=sys.stderr)
        return 1
    with tempfile.TemporaryDirectory() as folder:
        zipfile.ZipFile(wheel).extractall(folder)
        command = [str(python), str(SCRIPTS / "figure_drawings.py"), *wanted.names]
        return subprocess.run(command, env=os.environ | {"PYTHONPATH": folder}).returncode


if __name__ == "__main__":
    sys.exit(main())
