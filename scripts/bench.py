"""Measures the time of a live frame: the Armature modifier alone, with Corrective Smooth, and Sinew's elastic skin.

usage: python3 scripts/bench.py [--vertices 30000] [--muscles 75] [--iterations 5] [--preset human] [--rounds 6]
                                [--blender 5.2]

One run measures all deformers on one character, in turns, so that the ratios hold on a busy machine, too.
scripts/benchmarks/frame_in_blender.py does the work, with the built extension.
"""

import argparse
import sys

from build import blender, environment
from build.console import Failure
from build.layout import SCRIPTS
from data import body


def main() -> int:
    parser = argparse.ArgumentParser(description="Measures the time of a live frame, and of Blender's deformers.")
    parser.add_argument(
        "--vertices", type=int, default=30000, help="subdivide the body to about this number; 0: do not (30000)"
    )
    parser.add_argument("--muscles", type=int, default=75, help="number of the preset's muscles to keep; 0: all (75)")
    parser.add_argument("--iterations", type=int, default=5, help="of Corrective Smooth and of the elastic skin (5)")
    parser.add_argument("--preset", default="human", help="preset with the muscles (human)")
    parser.add_argument("--rounds", type=int, default=6, help="how many times each deformer plays all frames (6)")
    parser.add_argument("--blender", choices=environment.BLENDERS, default=environment.BLENDERS[0])
    wanted = parser.parse_args()
    numbers = (wanted.vertices, wanted.muscles, wanted.iterations, wanted.rounds)
    try:
        body.fetch()
        return blender.run(wanted.blender, SCRIPTS / "benchmarks/frame_in_blender.py", [wanted.preset, *map(str, numbers)])
    except Failure as error:
        print(f"sinew: {error}", file=sys.stderr)
        return 1


if __name__ == "__main__":
    sys.exit(main())
