"""Counts the poses of characters in which Sinew's skin is worse than that of the Armature modifier alone.

usage: python3 scripts/harm.py [--muscles auto|PRESET|corrective_smooth|preserve_volume] [--degrees 45,90] [--joints 16]
                               [--pairs 0] [--worse] [--blender 5.2|4.5] FILE...

FILE is a .glb, .gltf, .vrm, .fbx or .blend file with a rigged character. Each joint that carries skin is rotated by itself
about its X and Z, both ways, and about Y, by each angle. With --pairs, as many poses of two joints at once follow, chosen at
random but the same in every run. docs/mathematics/safeguard.md defines when a pose is worse. corrective_smooth and
preserve_volume sweep Blender's own deformers instead of Sinew. It prints a row of a Markdown table for each file; --worse
lists the poses that are worse. The exit code is 1 if there are any. scripts/benchmarks/harm_in_blender.py does the work.
"""

import argparse
import json
import sys
from pathlib import Path

from build import blender, environment
from build.console import Failure
from build.layout import SCRIPTS


def main() -> int:
    parser = argparse.ArgumentParser(
        description="Counts the poses in which Sinew's skin is worse than the Armature modifier's."
    )
    parser.add_argument("--muscles", default="auto", help="auto, a preset, corrective_smooth or preserve_volume (auto)")
    parser.add_argument("--degrees", default="45,90", metavar="ANGLE,...", help="angles of each joint (45,90)")
    parser.add_argument("--joints", type=int, default=16, help="most joints of a character, those with most skin (16)")
    parser.add_argument("--pairs", type=int, default=0, help="poses of two joints at once in addition (0)")
    parser.add_argument("--worse", action="store_true", help="list the poses that are worse")
    parser.add_argument("--blender", choices=environment.BLENDERS, default=environment.BLENDERS[0])
    parser.add_argument("files", nargs="+", type=Path, metavar="FILE")
    wanted = parser.parse_args()
    try:
        degrees = [float(angle) for angle in wanted.degrees.split(",")]
    except ValueError:
        parser.error(f"--degrees: expected angles such as 45,90, got {wanted.degrees}")
    missing = [str(file) for file in wanted.files if not file.is_file()]
    if missing:
        parser.error(f"there is no file {', '.join(missing)}")
    options = {
        "muscles": wanted.muscles,
        "degrees": degrees,
        "joints": wanted.joints,
        "pairs": wanted.pairs,
        "worse": wanted.worse,
        "files": [str(file.resolve()) for file in wanted.files],
    }
    try:
        return blender.run(wanted.blender, SCRIPTS / "benchmarks/harm_in_blender.py", [json.dumps(options)])
    except Failure as error:
        print(f"sinew: {error}", file=sys.stderr)
        return 1


if __name__ == "__main__":
    sys.exit(main())
