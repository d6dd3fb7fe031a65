"""Measures how the tissues of a preset fill bodies.

usage: python3 scripts/fill.py [--preset human] [--figure AVERAGE] [--details] [BODY...]

BODY is "makehuman" (the default) or a .blend, .glb or .fbx file with a rigged character. It prints a row of a Markdown
table for each body: the share of the body inside tissues and inside two or more, the tissue outside the skin as a share of
the body, the depth of the first tissue below the skin of trunk and limbs, and how many of 40 leg muscles have about their
measured volume. --details adds the parts of the body and each leg muscle. scripts/benchmarks/fill_in_blender.py does the
work.
"""

import argparse
import json
import sys
from pathlib import Path

from build import blender, environment
from build.console import Failure
from build.layout import SCRIPTS

BODY = "makehuman"


def main() -> int:
    parser = argparse.ArgumentParser(description="Measures how the tissues of a preset fill bodies.")
    parser.add_argument("--preset", default="human")
    parser.add_argument("--figure", help="LEAN, AVERAGE or STRONG (the operator's own)")
    parser.add_argument("--details", action="store_true", help="also print parts of the body and leg muscles")
    parser.add_argument("--blender", choices=environment.BLENDERS, default=environment.BLENDERS[0])
    parser.add_argument("bodies", nargs="*", default=[BODY], metavar="BODY")
    wanted = parser.parse_args()
    missing = [body for body in wanted.bodies if body != BODY and not Path(body).is_file()]
    if missing:
        parser.error(f"there is no file {', '.join(missing)}")
    options = {
        "preset": wanted.preset,
        "operator": {"figure": wanted.figure} if wanted.figure else {},
        "details": wanted.details,
        "bodies": [body if body == BODY else str(Path(body).resolve()) for body in wanted.bodies],
    }
    try:
        return blender.run(wanted.blender, SCRIPTS / "benchmarks/fill_in_blender.py", [json.dumps(options)])
    except Failure as error:
        print(f"sinew: {error}", file=sys.stderr)
        return 1


if __name__ == "__main__":
    sys.exit(main())
