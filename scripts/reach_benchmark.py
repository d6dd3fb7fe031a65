"""Compares reaching with both solvers of Blender's IK constraint: error, kept limits and time.

usage: python3 scripts/reach_benchmark.py [--goals N]

The chains have 4, 10 and 20 bones with hinges, twists and ball joints, all with limits. Each goal is where a random pose
within the limits ends. Every solver starts from the rest pose. scripts/benchmarks/reach_in_blender.py does the work, in bpy
5.2 with the built extension.
"""

import argparse
import sys

from build import blender, environment
from build.console import Failure
from build.layout import SCRIPTS


def main() -> int:
    parser = argparse.ArgumentParser(description="Compares reaching with Blender's IK constraint.")
    parser.add_argument("--goals", type=int, default=100, help="goals per chain (100)")
    wanted = parser.parse_args()
    try:
        return blender.run(environment.BLENDERS[0], SCRIPTS / "benchmarks/reach_in_blender.py", [str(wanted.goals)])
    except Failure as error:
        print(f"sinew: {error}", file=sys.stderr)
        return 1


if __name__ == "__main__":
    sys.exit(main())
