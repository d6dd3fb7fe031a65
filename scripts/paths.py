"""Compares the lengths of muscles in bending joints with those of a measured model.

usage: python3 scripts/paths.py [--preset human]

It bends the hip, the knee and the elbow of the MakeHuman body, and prints a row of a Markdown table for each muscle that
both have: how far its path changes in length, the largest difference from the model as a part of the model's muscle, and
the largest change of its lever arm from one degree to the next. The lengths of the model are those of
scripts/data/path_lengths.json, scaled by the length of the limb. scripts/benchmarks/paths_in_blender.py does the work.
"""

import argparse
import json
import sys

from build import blender, environment
from build.console import Failure
from build.layout import SCRIPTS
from data import body


def main() -> int:
    parser = argparse.ArgumentParser(description="Compares the lengths of muscles in bending joints with a measured model.")
    parser.add_argument("--preset", default="human")
    parser.add_argument("--blender", choices=environment.BLENDERS, default=environment.BLENDERS[0])
    wanted = parser.parse_args()
    try:
        body.fetch()
        options = json.dumps({"preset": wanted.preset})
        return blender.run(wanted.blender, SCRIPTS / "benchmarks/paths_in_blender.py", [options])
    except Failure as error:
        print(f"sinew: {error}", file=sys.stderr)
        return 1


if __name__ == "__main__":
    sys.exit(main())
