"""Writes LICENSES-third-party.txt: the licences of the crates that are compiled into the wheel, and of the presets' data.

usage: python3 scripts/third_party.py [--check]      (--check: writes nothing; exit code 1 if the file is out of date)

The texts come from the sources of the crates in cargo's registry. Where a crate may be used under one of several licences,
MIT is taken. The zip of the extension contains the file.
"""

import argparse
import json
import re
import subprocess
import sys
from pathlib import Path

from build.console import Failure
from build.layout import ROOT

TARGET = ROOT / "LICENSES-third-party.txt"
OWN = ("sinew", "sinew-core")
PREFERRED = (
    "LICENSE-MIT",
    "LICENSE-MIT.txt",
    "LICENSE-MIT.md",
    "LICENSE",
    "LICENSE.txt",
    "LICENSE.md",
    "COPYING",
    "LICENSE-APACHE",
)
ABOUT = """Sinew is licensed under GPL-3.0-or-later, see LICENSE. It contains parts of others, whose licences follow.
`python3 scripts/third_party.py` writes this file.
"""
DATA = """
====================================================================================================
Data of the presets limbs, human and myo: myo_sim 0.2.4 (PyPI), model myofullbody
====================================================================================================

Paths of muscles, as fractions of segments, changed as the field "sources" of each preset says. Licensed under the Apache
License, Version 2.0; the text is below, at the crate approx.

====================================================================================================
The standard library of Rust (MIT OR Apache-2.0), by The Rust Project contributors
====================================================================================================

The text of the MIT licence is below, at the crate num.
"""


def crates() -> list[dict]:
    """The crates that are compiled into the wheel on Linux, without Sinew's own and those that run at build time only."""
    tree = _cargo(
        "tree", "--locked", "-p", "sinew", "-e", "normal,no-proc-macro", "--target", "x86_64-unknown-linux-gnu",
        "--prefix", "none", "--format", "{p}",
    )  # fmt: skip
    linked = {tuple(line.split()[:2]) for line in tree.splitlines() if line.strip()}
    packages = json.loads(_cargo("metadata", "--locked", "--format-version", "1"))["packages"]
    chosen = [package for package in packages if (package["name"], f"v{package['version']}") in linked]
    return sorted(
        (package for package in chosen if package["name"] not in OWN), key=lambda found: (found["name"], found["version"])
    )


def text() -> str:
    """The file's text."""
    parts, texts = [ABOUT, DATA], {}
    for package in crates():
        licence = _licence_of(Path(package["manifest_path"]).parent)
        name = f"{package['name']} {package['version']}"
        line = "=" * 100
        parts.append(f"\n{line}\n{name} ({package['license']}), by {_authors_of(package)}\n{line}\n")
        if licence is None:
            parts.append(f"\nThe crate has no file with a licence. Its Cargo.toml says: {package['license']}.\n")
        elif licence in texts:
            parts.append(f"\nThe text is the same as for {texts[licence]}.\n")
        else:
            texts[licence] = name
            parts.append(f"\n{licence.strip()}\n")
    return "".join(parts)


def _authors_of(package: dict) -> str:
    """The names of a crate's authors, without their addresses."""
    names = [re.sub(r"\s*[<(].*", "", author) for author in package["authors"]]
    return ", ".join(names) or "its authors"


def _licence_of(folder: Path) -> str | None:
    found = next((folder / name for name in PREFERRED if (folder / name).is_file()), None)
    return "\n".join(line.rstrip() for line in found.read_text(encoding="utf-8").splitlines()) if found else None


def _cargo(*arguments: str) -> str:
    done = subprocess.run(["cargo", *arguments], cwd=ROOT, capture_output=True, text=True)
    if done.returncode != 0:
        raise Failure(f"cargo {arguments[0]} failed with {done.returncode}:\n{done.stderr.rstrip()}")
    return done.stdout


def main() -> None:
    parser = argparse.ArgumentParser(description="Writes LICENSES-third-party.txt.")
    parser.add_argument("--check", action="store_true", help="write nothing; fail if the file is out of date")
    wanted = parser.parse_args()
    try:
        written = text()
    except Failure as error:
        sys.exit(f"sinew: {error}")
    if not wanted.check:
        TARGET.write_text(written, encoding="utf-8")
    elif not TARGET.is_file() or TARGET.read_text(encoding="utf-8") != written:
        sys.exit(f"sinew: {TARGET.name} is out of date. Run python3 scripts/third_party.py")


if __name__ == "__main__":
    main()
