"""Prints the matrices of the public CI as JSON: systems, Blenders and Pythons, read from the manifest and the scripts.

usage: python3 scripts/ci_matrix.py     (one line `name=JSON` for each matrix, for $GITHUB_OUTPUT)

The Blenders are those of scripts/build/environment.py, and the manifest's oldest Blender must be among them.
"""

import json
import sys
import tomllib

from build import environment
from build.console import Failure
from build.layout import ROOT

# (runner, platform in the spelling of the manifest)
SYSTEMS = (
    ("ubuntu-24.04", "linux-x64"),
    ("windows-2025", "windows-x64"),
    ("macos-15", "macos-arm64"),
    ("macos-15-intel", "macos-x64"),
)
# Blender 5 does not run on macOS with Intel processors
MISSING = {("macos-x64", "5.2")}
# (Python, numpy): every Python from the oldest Blender's on, the oldest numpy that is supported, and the newest ("")
PYTHONS = (("3.11", "1.26.4"), ("3.11", ""), ("3.12", "1.26.4"), ("3.12", ""), ("3.13", ""), ("3.14", ""))


def matrices() -> dict[str, list[dict[str, str]]]:
    """The matrices by their names. Raises Failure if the manifest's oldest Blender is not tested."""
    manifest = tomllib.loads((ROOT / "addon/blender_manifest.toml").read_text(encoding="utf-8"))
    oldest = ".".join(manifest["blender_version_min"].split(".")[:2])
    tested = sorted(environment.BLENDERS, key=_number)
    if oldest != tested[0]:
        raise Failure(
            f"the manifest's blender_version_min is {oldest}, and the oldest Blender that is tested is {tested[0]}"
        )
    systems = [{"runner": runner, "platform": platform} for runner, platform in SYSTEMS]
    return {
        "systems": systems,
        "blenders": [
            system | {"blender": blender}
            for system in systems
            for blender in tested
            if (system["platform"], blender) not in MISSING
        ],
        "pythons": [{"python": python, "numpy": numpy} for python, numpy in PYTHONS],
    }


def _number(version: str) -> tuple[int, ...]:
    return tuple(int(part) for part in version.split("."))


def main() -> None:
    try:
        for name, entries in matrices().items():
            print(f"{name}={json.dumps({'include': entries})}")
    except Failure as error:
        sys.exit(f"sinew: {error}")


if __name__ == "__main__":
    main()
