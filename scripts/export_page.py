"""Exports the demo's body to glTF, plays it with three.js in headless Chromium, and compares the result with Blender.

usage: python3 scripts/export_page.py [--keys correctives|frames] [--blender 5.2|4.5] [--output DIR] [--serve]

It needs node and npm (Debian: apt-get install nodejs npm). npm installs three.js, puppeteer and a Chromium for x86-64 Linux
into .build/player, at the versions of scripts/exports/player/package-lock.json. The script writes body.glb and player.png
into DIR (demo/export). player.png shows Blender's live skin and the page in the same frame with the same camera. The script
prints the distances between the page's vertices, which three.js morphs and skins, and Blender's. --serve then serves the
page, so that it can be opened in another browser.
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
    """The folder of the player, with its packages from npm."""
    for program in ("node", "npm"):
        if shutil.which(program) is None:
            raise Failure(f"{program} was not found. The page needs node and npm (Debian: apt-get install nodejs npm)")
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


def play(glb: Path, request: Path, folder: Path) -> dict:
    """Plays a file in headless Chromium, writes points and pictures into `folder`, and returns the page's report."""
    run(["node", player() / "play.mjs", glb, request, folder])
    return json.loads((folder / "report.json").read_text())


def main() -> int:
    parser = argparse.ArgumentParser(description="Exports the demo's body to glTF and plays it in a browser.")
    parser.add_argument("--keys", choices=["correctives", "frames"], default="correctives")
    parser.add_argument("--blender", choices=environment.BLENDERS, default=environment.BLENDERS[0])
    parser.add_argument("--output", type=Path, metavar="DIR", default=ROOT / "demo" / "export")
    parser.add_argument("--serve", action="store_true", help="serve the page at the end, for a browser")
    wanted = parser.parse_args()
    output = wanted.output.resolve()
    in_blender = SCRIPTS / "exports/page_in_blender.py"
    try:
        output.mkdir(parents=True, exist_ok=True)
        folder = player()
        body.fetch()
        if blender.run(wanted.blender, in_blender, ["export", wanted.keys, str(output)]) != 0:
            raise Failure("The export failed")
        with step("playing body.glb in Chromium"):
            report = play(output / "body.glb", output / "request.json", output)
        counts = f"{report['clips']}, {report['morphs']} morphs, {report['bones']} bones"
        say(f"three.js r{report['three']}, {report['browser']}: {counts}")
        for message in report["messages"]:
            say(f"message of the browser: {message}")
        code = blender.run(wanted.blender, in_blender, ["compare", wanted.keys, str(output)])
        if wanted.serve and code == 0:
            subprocess.run(["node", folder / "play.mjs", output / "body.glb"], check=False)
        return code
    except Failure as error:
        sys.exit(f"sinew: {error}")


if __name__ == "__main__":
    sys.exit(main())
