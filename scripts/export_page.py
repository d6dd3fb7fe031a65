"""Exports the demo's body to glTF and plays it in a browser: three.js in headless Chromium, held against Blender.

usage: python3 scripts/export_page.py [--keys correctives|frames] [--blender 5.2|4.5] [--output DIR] [--serve]

Needs node and npm (Debian: apt-get install nodejs npm). three.js, puppeteer and a Chromium for x86-64 Linux come from npm, at the versions of
scripts/exports/player/package-lock.json, into .build/player. DIR (demo/export) gets body.glb and player.png: Blender's live skin beside
the page, in the same frame through the same camera. What is printed are the distances of the page's vertices, morphed and
skinned by three.js itself, from Blender's. --serve then shows the page to a person's own browser.
"""

import argparse
import json
import shutil
import subprocess
import sys
from pathlib import Path

from build import blender, environment
from build.console import Failure, run, say, step
from build.layout import BUILD, ROOT, SCRIPTS
from build.once import building, fingerprint, is_stamped
from data import body

PLAYER = SCRIPTS / "exports/player"
INSTALLED = BUILD / "player"


def player() -> Path:
    """The folder of the player, with what it needs from npm."""
    for program in ("node", "npm"):
        if shutil.which(program) is None:
            raise Failure(f"{program} was not found: the page needs node and npm (Debian: apt-get install nodejs npm)")
    stamp, mark = INSTALLED / "sinew.stamp", fingerprint(PLAYER, [PLAYER / "package-lock.json"])
    with building():
        if not is_stamped(stamp, mark):
            shutil.rmtree(INSTALLED, ignore_errors=True)
            INSTALLED.mkdir(parents=True)
            for name in ("package.json", "package-lock.json"):
                shutil.copy(PLAYER / name, INSTALLED)
            with step("three.js, puppeteer and Chromium from npm (90 MB)"):
                run(["npm", "ci", "--ignore-scripts", "--no-audit", "--no-fund"], cwd=INSTALLED)
            stamp.write_text(mark)
    for source in PLAYER.iterdir():
        shutil.copy(source, INSTALLED)
    return INSTALLED


def play(glb: Path, asked: Path, folder: Path) -> dict:
    """Plays a file in headless Chromium; `folder` gets points and pictures. Returns what the page told."""
    run(["node", player() / "play.mjs", glb, asked, folder])
    return json.loads((folder / "told.json").read_text())


def main() -> int:
    parser = argparse.ArgumentParser(description="Exports the demo's body to glTF and plays it in a browser.")
    parser.add_argument("--keys", choices=["correctives", "frames"], default="correctives")
    parser.add_argument("--blender", choices=environment.BLENDERS, default=environment.BLENDERS[0])
    parser.add_argument("--output", type=Path, metavar="DIR", default=ROOT / "demo" / "export")
    parser.add_argument("--serve", action="store_true", help="show the page to a person's browser at the end")
    wanted = parser.parse_args()
    output = wanted.output.resolve()
    in_blender = SCRIPTS / "exports/page_in_blender.py"
    try:
        output.mkdir(parents=True, exist_ok=True)
        folder = player()
        body.fetch()
        if blender.run(wanted.blender, in_blender, ["export", wanted.keys, str(output)]) != 0:
            raise Failure("the export failed")
        with step("playing body.glb in Chromium"):
            told = play(output / "body.glb", output / "asked.json", output)
        say(f"three.js r{told['three']}, {told['browser']}: {told['clips']}, {told['morphs']} morphs, {told['bones']} bones")
        for complaint in told["complaints"]:
            say(f"the browser says: {complaint}")
        code = blender.run(wanted.blender, in_blender, ["compare", wanted.keys, str(output)])
        if wanted.serve and code == 0:
            subprocess.run(["node", folder / "play.mjs", output / "body.glb"], check=False)
        return code
    except Failure as error:
        sys.exit(f"sinew: {error}")


if __name__ == "__main__":
    sys.exit(main())
