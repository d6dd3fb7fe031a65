"""Measures how well bent joints keep their shape, with Blender's deformers and with Sinew's elastic skin, on a real body.

usage: python3 scripts/quality.py [--preset limbs] [--only elbow,knee] [--poses elbow:75,knee:100] [--sweep]
                                  [--tables key,combined,shape] [--pictures [DIR]] [--iterations N] [--save BODY.blend]

For each pose it prints, with the required values: the union volume around the joint compared with rest, the edge stretch,
the inverted faces, the new self-intersections around the joint and anywhere, and the dihedral bend. Further tables show
several joints at once, how far creases stay open, and how far muscles raise the skin. --sweep adds pop and jitter in steps
of a degree, --pictures writes sections.png and turntable.png. docs/mathematics/quality.md defines the measures.
scripts/benchmarks/quality_in_blender.py does the work, in bpy 5.2 with the built extension.
"""

import argparse
import json
import sys
from pathlib import Path

from build import blender, environment
from build.console import Failure
from build.layout import ROOT, SCRIPTS
from data import body

TABLES = ("key", "combined", "shape")


def main() -> int:
    parser = argparse.ArgumentParser(description="Measures how well bent joints keep their shape.")
    parser.add_argument("--preset", default="limbs", help="preset with the muscles (limbs)")
    parser.add_argument("--iterations", type=int, help="iterations of the elastic skin (its default)")
    parser.add_argument("--only", default="", metavar="JOINT,...", help="measure only these joints, such as elbow,knee")
    parser.add_argument(
        "--poses", default="", metavar="JOINT:DEGREES,...", help="poses of the first table, such as elbow:75"
    )
    parser.add_argument(
        "--tables", default=",".join(TABLES), metavar="TABLE,...", help=f"tables out of {', '.join(TABLES)} (all)"
    )
    parser.add_argument("--sweep", action="store_true", help="also measure pop and jitter in steps of a degree")
    parser.add_argument(
        "--pictures", nargs="?", type=Path, const=ROOT / "docs", metavar="DIR", help="write pictures here (docs)"
    )
    parser.add_argument("--save", type=Path, metavar="BODY.blend", help="save the bound body, for other measurements")
    wanted = parser.parse_args()
    try:
        pairs = [pose.split(":") for pose in wanted.poses.split(",") if pose]
        poses = [(joint, int(degrees)) for joint, degrees in pairs]
    except ValueError:
        parser.error(f"--poses: expected pairs such as elbow:75,knee:100, got {wanted.poses}")
    options = {
        "preset": wanted.preset,
        "iterations": wanted.iterations,
        "only": [joint for joint in wanted.only.split(",") if joint],
        "poses": poses,
        "tables": [table for table in wanted.tables.split(",") if table] + ["sweep"] * wanted.sweep,
        "pictures": str(wanted.pictures.resolve()) if wanted.pictures else None,
        "save": str(wanted.save.resolve()) if wanted.save else None,
    }
    try:
        body.fetch()
        return blender.run(environment.BLENDERS[0], SCRIPTS / "benchmarks/quality_in_blender.py", [json.dumps(options)])
    except Failure as error:
        print(f"sinew: {error}", file=sys.stderr)
        return 1


if __name__ == "__main__":
    sys.exit(main())
