"""The pages of this repository as Markdown: their links, anchors and blocks of code."""

import re
from dataclasses import dataclass
from pathlib import Path

from build.layout import ROOT

FENCE = re.compile(r"^(?P<fence>`{3,})(?P<language>[^\n`]*)\n(?P<code>.*?)^(?P=fence)[ ]*$", re.MULTILINE | re.DOTALL)
LINK = re.compile(r"!?\[(?:[^\[\]]|\[[^\]]*\])*\]\(([^()\s]+)\)")
HEADING = re.compile(r"^#+ +(.+?) *#*$", re.MULTILINE)


@dataclass(frozen=True)
class Block:
    """A fenced block of code. line: the number of its first line of code."""

    page: Path
    line: int
    language: str
    code: str

    def __str__(self):
        return f"{name_of(self.page)}:{self.line}"


def all_pages() -> list[Path]:
    """All Markdown files at the top of the repository, in docs and in .github, sorted."""
    return sorted([*ROOT.glob("*.md"), *(ROOT / "docs").rglob("*.md"), *(ROOT / ".github").rglob("*.md")])


def name_of(page: Path) -> str:
    return page.relative_to(ROOT).as_posix()


def blocks_of(page: Path) -> list[Block]:
    """The fenced blocks of a page, in order."""
    text = page.read_text(encoding="utf-8")
    return [
        Block(page, text.count("\n", 0, match.start("code")) + 1, match["language"].strip(), match["code"])
        for match in FENCE.finditer(text)
    ]


def links_of(page: Path) -> list[str]:
    """The targets of all links and pictures of a page."""
    prose = FENCE.sub("", page.read_text(encoding="utf-8"))
    return LINK.findall(re.sub(r"`[^`\n]*`", "``", prose))


def anchors_of(page: Path) -> set[str]:
    """The anchors of a page's headings, as GitHub and MkDocs make them."""
    prose = FENCE.sub("", page.read_text(encoding="utf-8"))
    return {
        re.sub(r"[^\w\- ]", "", heading.lower().replace("`", "")).strip().replace(" ", "-")
        for heading in HEADING.findall(prose)
    }


def problem_of(page: Path, target: str) -> str:
    """Why a link inside the repository is dead, or an empty text."""
    path, _, anchor = target.partition("#")
    file = (page.parent / path).resolve() if path else page
    if not file.exists():
        return f"{name_of(page)}: {target} does not exist"
    if anchor and file.suffix == ".md" and anchor not in anchors_of(file):
        return f"{name_of(page)}: {name_of(file)} has no heading #{anchor}"
    return ""
