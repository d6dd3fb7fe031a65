"""Measures how the time of a live frame grows with vertices, muscles, iterations, threads and characters.

usage: python3 scripts/scaling.py [--rounds 3] [--only vertices] [--plot FILE.svg] [--blender 5.2]

The character is that of scripts/bench.py. scripts/benchmarks/scaling_in_blender.py does the work, with the built extension.
Each row also has the time of the Armature modifier alone in the same frames: compare ratios, since other programs slow both.
"""

import argparse
import sys

from build import blender, environment
from build.console import Failure
from build.layout import SCRIPTS
from data import body

AXES = ("vertices", "muscles", "iterations", "threads", "characters")


def main() -> int:
    parser = argparse.ArgumentParser(description="Measures how the time of a live frame grows.")
    parser.add_argument("--rounds", type=int, default=3, help="how many times all frames are played for a row (3)")
    parser.add_argument("--only", choices=AXES, help="measure along one axis only")
    parser.add_argument("--plot", default="", metavar="FILE.svg", help="also draw the times")
    parser.add_argument("--blender", choices=environment.BLENDERS, default=environment.BLENDERS[0])
    wanted = parser.parse_args()
    arguments = [str(wanted.rounds), wanted.only or ",".join(AXES), wanted.plot]
    try:
        body.fetch()
        return blender.run(wanted.blender, SCRIPTS / "benchmarks/scaling_in_blender.py", arguments)
    except Failure as error:
        print(f"sinew: {error}", file=sys.stderr)
        return 1


if __name__ == "__main__":
    sys.exit(main())
