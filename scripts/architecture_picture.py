"""Draws docs/architecture.svg: the rooms of the add-on and of the core, and the imports between them, read from the sources.

usage: python3 scripts/architecture_picture.py [--check]     (--check: fails if the picture is out of date)
"""

import argparse
import ast
import re
import sys
import textwrap
from html import escape
from pathlib import Path

from build.layout import ROOT
from testing import imports

TARGET = ROOT / "docs/architecture.svg"
ROOM_WIDTH, ROOM_HEIGHT, GAP, LEFT, TOP, COLUMN = 560, 30, 14, 20, 90, 850
LONGEST_PURPOSE = 70
EVERYWHERE = ("errors", "error")  # every room imports these, and their arcs would hide the others
STYLE = (
    "text{font:13px sans-serif;fill:#222}.title{font-weight:bold;font-size:15px}.small{font-size:11px;fill:#666}"
    "rect{fill:#f4efe6;stroke:#7a6a52}path{fill:none;stroke:#7a6a52;opacity:.55}"
)


def picture() -> str:
    """The SVG's text: one column for the add-on and one for the core, with an arc from each room to each room it imports."""
    columns = [
        ("addon (Python, knows Blender)", imports.ADDON, imports.of_addon(), imports.ADDON_ROOMS),
        ("rust/core (Rust, knows no Python)", imports.CORE, imports.of_core(), imports.CORE_ROOMS),
    ]
    parts = [
        part for number, (title, folder, found, rooms) in enumerate(columns)
        for part in _column(LEFT + number * COLUMN, title, folder, imports.between_rooms(found), rooms)
    ]  # fmt: skip
    height = TOP + max(len(rooms) for *_, rooms in columns) * (ROOM_HEIGHT + GAP)
    width = LEFT + 2 * COLUMN - 30
    note = (
        "A room imports only from rooms above it. The width of an arc grows with the number of imports. "
        "Imports of errors are left out."
    )
    head = f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" width="{width}" height="{height}">'
    return "\n".join(
        [head, f"<style>{STYLE}</style>", f'<text x="20" y="28" class="small">{note}</text>', *parts, "</svg>", ""]
    )


def _column(left: int, title: str, folder, counts: dict[tuple[str, str], int], rooms: tuple[str, ...]) -> list[str]:
    present = [room for room in rooms if (folder / room).is_dir() or list(folder.glob(f"{room}.*"))]
    middle = {room: TOP + row * (ROOM_HEIGHT + GAP) for row, room in enumerate(present)}
    parts = [f'<text x="{left}" y="{TOP - 34}" class="title">{escape(title)}</text>']
    for (importer, imported), count in sorted(counts.items()):
        if imported in EVERYWHERE:
            continue
        start, end = middle[importer], middle[imported]
        x, bow = left + ROOM_WIDTH, 18 + abs(start - end) * 0.42
        width = min(1.0 + count / 8.0, 6.0)
        parts.append(
            f'<path d="M{x} {start} C{x + bow:.0f} {start} {x + bow:.0f} {end} {x} {end}" stroke-width="{width:.1f}">'
            f"<title>{importer} imports {imported}: {count}</title></path>"
        )
    for room, y in middle.items():
        parts += [
            f'<rect x="{left}" y="{y - ROOM_HEIGHT / 2:.0f}" width="{ROOM_WIDTH}" height="{ROOM_HEIGHT}" rx="4"/>',
            f'<text x="{left + 10}" y="{y + 5}">{escape(room)}</text>',
            f'<text x="{left + 120}" y="{y + 4}" class="small">{escape(_purpose(folder, room))}</text>',
        ]
    return parts


def _purpose(folder: Path, room: str) -> str:
    """The first sentence of a room's own documentation."""
    candidates = [folder / room / "__init__.py", folder / room / "mod.rs", folder / f"{room}.py", folder / f"{room}.rs"]
    text = next(file for file in candidates if file.is_file()).read_text(encoding="utf-8")
    comment = re.match(r"((?://!.*\n)+)", text)
    words = (
        " ".join(line[3:].strip() for line in comment[1].splitlines())
        if comment
        else ast.get_docstring(ast.parse(text)) or ""
    )
    sentence = " ".join(words.split()).partition(". ")[0].rstrip(".").replace("`", "").replace("[", "").replace("]", "")
    return textwrap.shorten(sentence, LONGEST_PURPOSE, placeholder=" ...")


def main() -> int:
    parser = argparse.ArgumentParser(description="Draws docs/architecture.svg from the imports in the sources.")
    parser.add_argument("--check", action="store_true", help="write nothing; exit code 1 if the file is out of date")
    wanted = parser.parse_args()
    drawn = picture()
    if not wanted.check:
        TARGET.write_text(drawn, encoding="utf-8")
        print(TARGET)
        return 0
    if TARGET.is_file() and TARGET.read_text(encoding="utf-8") == drawn:
        return 0
    print(f"{TARGET} is out of date: run python3 scripts/architecture_picture.py", file=sys.stderr)
    return 1


if __name__ == "__main__":
    sys.exit(main())
