"""Fetches the data of a real body, and saves the body as a .blend file on request.

usage: python3 scripts/body.py [--output BODY.blend]        (prints the fetched file's path)
"""

import argparse
import os
import sys
from pathlib import Path

from build import environment
from build.console import Failure, run
from build.layout import SCRIPTS
from data import body


def main() -> None:
    parser = argparse.ArgumentParser(description="Fetches the data of a real body.")
    parser.add_argument("--output", type=Path, metavar="BODY.blend", help="save the body in this file")
    wanted = parser.parse_args()
    try:
        print(body.fetch())
        if wanted.output:
            python = environment.blender(environment.BLENDERS[0])
            run(
                [python, SCRIPTS / "data/body_in_blender.py", wanted.output.resolve()],
                env=os.environ | {"PYTHONPATH": str(SCRIPTS)},
            )
    except Failure as error:
        sys.exit(f"sinew: {error}")


if __name__ == "__main__":
    main()
