"""Measures reaching beside Blender's own IK constraint, with both of its solvers: error, limits kept, time.

usage: python3 scripts/reach_benchmark.py [--goals N]

Chains of 4, 10 and 20 bones with hinges, twists and ball joints in limits; goals that a random pose within the limits
reaches; each from the rest pose, for all the same. reach_benchmark_in_blender.py does it, in bpy 5.2 with the built extension.
"""

import argparse
import sys

from build import blender, environment
from build.console import Failure
from build.layout import SCRIPTS


def main() -> int:
    parser = argparse.ArgumentParser(description="Measures reaching beside Blender's own IK constraint.")
    parser.add_argument("--goals", type=int, default=100, help="goals a chain (100)")
    wanted = parser.parse_args()
    try:
        return blender.run(environment.BLENDERS[0], SCRIPTS / "benchmarks/reach_in_blender.py", [str(wanted.goals)])
    except Failure as error:
        print(f"sinew: {error}", file=sys.stderr)
        return 1


if __name__ == "__main__":
    sys.exit(main())
