"""The version that is released is the same in every file that states one, and in the tag."""

import re
import tomllib
from pathlib import Path

from build.layout import ROOT

MANIFEST = "addon/blender_manifest.toml"
_HEADING = re.compile(r"^## (\d+\.\d+\.\d+)(?: - (\d{4}-\d{2}-\d{2}|not released))?$", re.MULTILINE)


def of_manifest(root: Path = ROOT) -> str:
    """The version of the extension."""
    return tomllib.loads((root / MANIFEST).read_text(encoding="utf-8"))["version"]


def disagreements(root: Path = ROOT) -> list[str]:
    """One line for each file that states another version than the manifest."""
    version = of_manifest(root)
    crates = tomllib.loads((root / "Cargo.toml").read_text(encoding="utf-8"))["workspace"]["package"]["version"]
    cited = re.search(r"^version: *[\"']?([^\s\"']+)", (root / "CITATION.cff").read_text(encoding="utf-8"), re.MULTILINE)
    newest = _newest_change(root)
    stated = {"Cargo.toml": crates, "CITATION.cff": cited and cited[1], "CHANGELOG.md": newest and newest[1]}
    return [f"{name} has {found}, and {MANIFEST} has {version}" for name, found in stated.items() if found != version]


def release_problems(tag: str, root: Path = ROOT) -> list[str]:
    """One line for each reason why this tag cannot be released: another version, or no date in the changelog."""
    version = of_manifest(root)
    problems = disagreements(root)
    if tag != f"v{version}":
        problems.append(f"the tag is {tag}, and {MANIFEST} needs the tag v{version}")
    newest = _newest_change(root)
    if newest and not re.fullmatch(r"[\d-]+", newest[2] or ""):
        problems.append(f"CHANGELOG.md has no date for {newest[1]}. Write ## {newest[1]} - YYYY-MM-DD")
    return problems


def notes(root: Path = ROOT) -> str:
    """The changelog's text about the newest version, without its heading."""
    text = (root / "CHANGELOG.md").read_text(encoding="utf-8")
    headings = list(_HEADING.finditer(text))
    if not headings:
        return ""
    end = headings[1].start() if len(headings) > 1 else len(text)
    return text[headings[0].end() : end].strip()


def _newest_change(root: Path) -> re.Match | None:
    return _HEADING.search((root / "CHANGELOG.md").read_text(encoding="utf-8"))
