"""Runs the measurements of the documentation and writes what they print into docs/measured, a page for each.

usage: python3 scripts/measurements.py [NAME ...]        (without a name: all of them, which takes an hour)

Each page has the command, the commit of the sources, the machine and the output, as it was printed. The sources must be
committed, because a page names their commit. Times depend on the machine and on what else runs on it.
"""

import argparse
import os
import platform
import subprocess
import sys
import tempfile

from build.console import Failure, say, step
from build.layout import ROOT

PAGES = ROOT / "docs/measured"
SOURCES = ("addon", "rust", "scripts", "Cargo.lock")
IN_BLENDER = "scripts/run_in_blender.py"
# (title, command without python3) by name; a page of the documentation that discusses a measurement links to it
MEASUREMENTS = {
    "frame": ("A live frame", ["scripts/bench.py"]),
    "scaling": ("How a live frame grows", ["scripts/scaling.py"]),
    "quality": ("Bent joints", ["scripts/quality.py", "--sweep"]),
    "bake": ("Baked frames and correctives", [IN_BLENDER, "scripts/benchmarks/bake_table.py"]),
    "growth": ("Grown skins", [IN_BLENDER, "scripts/benchmarks/growth_table.py", "--rounds", "7"]),
    "reach": ("Reaching, beside Blender's IK constraint", ["scripts/reach_benchmark.py"]),
    "export": ("Exported files", [IN_BLENDER, "scripts/exports/table.py"]),
    "demo": ("The demo", ["scripts/demo.py", "--output", "DIR"]),
}


def page(name: str, output: str, commit: str) -> str:
    """The page of a measurement as Markdown."""
    title, command = MEASUREMENTS[name]
    lines = "\n".join(line.rstrip() for line in output.strip().splitlines())
    machine = f"{platform.system()} {platform.machine()}, {os.cpu_count()} cores"
    return (
        f"# {title}\n\n`python3 {' '.join(command)}` printed this on {machine}. `python3 scripts/measurements.py {name}` "
        f"writes this page.\n\nMeasured at commit `{commit}`.\n\n```text\n{lines}\n```\n"
    )


def measure(name: str) -> str:
    """What the command of a measurement prints. Raises Failure with the end of its messages if it fails."""
    with tempfile.TemporaryDirectory() as folder:
        command = [folder if word == "DIR" else word for word in MEASUREMENTS[name][1]]
        with step(f"measuring {name}"):
            done = subprocess.run([sys.executable, *command], cwd=ROOT, capture_output=True, text=True)
    if done.returncode != 0:
        raise Failure(f"{' '.join(command)} failed with {done.returncode}:\n{done.stderr[-2000:]}")
    if not done.stdout.strip():
        raise Failure(f"{' '.join(command)} printed nothing")
    return done.stdout


def commit_of_sources() -> str:
    """The commit that is measured. Raises Failure if sources differ from it."""
    changed = _git("status", "--porcelain", "--", *SOURCES)
    if changed:
        raise Failure(f"these sources are not committed, so no commit names them:\n{changed}")
    return _git("log", "-1", "--format=%h", "--abbrev=8", "--", *SOURCES)


def _git(*arguments: str) -> str:
    return subprocess.run(["git", *arguments], cwd=ROOT, capture_output=True, text=True, check=True).stdout.strip()


def main() -> None:
    parser = argparse.ArgumentParser(description="Runs the measurements of the documentation.")
    parser.add_argument("names", nargs="*", metavar="NAME", help=f"{', '.join(MEASUREMENTS)} (all)")
    wanted = parser.parse_args()
    unknown = sorted(set(wanted.names) - set(MEASUREMENTS))
    if unknown:
        parser.error(f"there is no measurement {unknown[0]}; there are {', '.join(MEASUREMENTS)}")
    try:
        commit = commit_of_sources()
        PAGES.mkdir(exist_ok=True)
        for name in wanted.names or MEASUREMENTS:
            target = PAGES / f"{name}.md"
            target.write_text(page(name, measure(name), commit), encoding="utf-8")
            say(f"written: {target.relative_to(ROOT)}")
    except Failure as error:
        sys.exit(f"sinew: {error}")


if __name__ == "__main__":
    main()
