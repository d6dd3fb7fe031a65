"""Measures how well bent joints keep their shape: Blender's Armature modifier, Sinew, and Sinew's elastic skin, on a real body.

usage: python3 scripts/quality.py [--preset limbs|human]

For each pose: the volume around the joint against rest, and the pairs of triangles of the whole body that newly cut each
other. quality_in_blender.py does it, in bpy 5.2 with the built extension.
"""

import argparse
import sys

import blender
import body
import environment
from console import Failure
from layout import SCRIPTS


def main() -> int:
    parser = argparse.ArgumentParser(description="Measures how well bent joints keep their shape.")
    parser.add_argument("--preset", default="limbs", help="the muscles to measure with (limbs)")
    wanted = parser.parse_args()
    try:
        body.fetch()
        return blender.run(environment.BLENDERS[0], SCRIPTS / "quality_in_blender.py", [wanted.preset])
    except Failure as error:
        print(f"sinew: {error}", file=sys.stderr)
        return 1


if __name__ == "__main__":
    sys.exit(main())
