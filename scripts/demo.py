"""Makes a demo of Sinew: a body whose arms and legs flex with bulging muscles, baked, and a picture of it.

usage: python3 scripts/demo.py [--motion flex|reach | --animal NAME] [--output DIR]     (DIR: demo/ in the repository)

The script makes the environment, builds the extension, installs its zip in bpy 5.2 as a user does, and runs demos/scene.py
there, which writes demo.blend and demo.png into DIR and prints a short table. With --motion reach it runs demos/reach.py: a
hand reaches the head and a foot reaches a step, in demo_reach.blend and demo_reach.png. With --animal it runs
demos/animal.py: a skin grown over the muscles of a cat, dog, horse, toad, hand or human moves, in cat.blend and cat.png.
"""

import argparse
import sys
import time
from pathlib import Path

from build import blender, environment
from build.console import Failure, say
from build.layout import ROOT, SCRIPTS
from data import body

SCENES = {"flex": "demos/scene.py", "reach": "demos/reach.py"}


def main() -> int:
    parser = argparse.ArgumentParser(description="Makes demo.blend and demo.png with Sinew, and prints a short table.")
    parser.add_argument("--output", type=Path, metavar="DIR", default=ROOT / "demo", help="folder for the files (demo/)")
    what = parser.add_mutually_exclusive_group()
    what.add_argument("--motion", choices=tuple(SCENES), default="flex", help="motion of the body (flex)")
    what.add_argument(
        "--animal", choices=["cat", "dog", "horse", "toad", "hand", "human"], help="grow a skin over its muscles"
    )
    wanted = parser.parse_args()
    output = wanted.output.resolve()
    start = time.perf_counter()
    try:
        output.mkdir(parents=True, exist_ok=True)
        if wanted.animal:
            code = blender.run(environment.BLENDERS[0], SCRIPTS / "demos/animal.py", [wanted.animal, str(output)])
        else:
            body.fetch()
            code = blender.run(environment.BLENDERS[0], SCRIPTS / SCENES[wanted.motion], [str(output)])
    except Failure as error:
        sys.exit(f"sinew: {error}")
    say(f"the whole demo: {time.perf_counter() - start:.0f} s" if code == 0 else f"the demo failed with {code}")
    return code


if __name__ == "__main__":
    sys.exit(main())
