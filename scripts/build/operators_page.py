"""Writes docs/operators.md: every operator with its label, its meaning and its options.

usage: python3 scripts/run_in_blender.py scripts/build/operators_page.py
"""

from pathlib import Path

import bpy

PAGE = Path(__file__).resolve().parents[2] / "docs" / "operators.md"
ABOUT = """# Operators

Scripts call these as `bpy.ops.sinew.NAME(...)`. They work on the active object, as the panels do. An operator that cannot do
its work raises `RuntimeError` with the message that a user would see. [Scripting](scripting.md) has examples.

`python3 scripts/run_in_blender.py scripts/build/operators_page.py` writes this page.
"""
# Options that Blender's file selector adds to an operator, such as those that show files of one type only.
OF_FILE_SELECTOR = (
    "filter_",
    "hide_props_region",
    "display_type",
    "sort_method",
    "check_existing",
    "filemode",
    "relative_path",
)


def text() -> str:
    """The page as Markdown."""
    return "\n".join([ABOUT, *(_operator(name) for name in sorted(dir(bpy.ops.sinew)))])


def _operator(name: str) -> str:
    about = getattr(bpy.ops.sinew, name).get_rna_type()
    options = [
        known for known in about.properties
        if known.identifier != "rna_type" and not known.identifier.startswith(OF_FILE_SELECTOR) and not known.is_hidden
    ]  # fmt: skip
    lines = [f"## sinew.{name}", "", f"**{about.name}.** {about.description}.", ""]
    if options:
        lines += ["| Option | Label | Meaning | Default |", "|---|---|---|---|", *map(_row, options), ""]
    return "\n".join(lines)


def _row(known) -> str:
    meaning = known.description
    if known.type == "ENUM":
        items = "; ".join(f"`{item.identifier}` ({item.name}): {item.description}" for item in known.enum_items)
        meaning = f"{meaning}. {items}" if items else meaning
    cells = (f"`{known.identifier}`", known.name, meaning, _default(known))
    return f"| {' | '.join(cell.replace('|', '/') for cell in cells)} |"


def _default(known) -> str:
    if known.type in ("COLLECTION", "POINTER"):
        return ""
    if known.type == "ENUM" and known.is_enum_flag:
        return f"`{sorted(known.default_flag)!r}`"
    if known.type == "ENUM":
        return f"`{known.default}`" if known.default else ""
    if getattr(known, "is_array", False):
        return f"`{tuple(round(value, 6) for value in known.default_array)}`"
    if known.type == "FLOAT":
        return f"`{known.default:.6g}`"
    return f"`{known.default!r}`" if known.default != "" else ""


if __name__ == "__main__":
    PAGE.write_text(text(), encoding="utf-8")
