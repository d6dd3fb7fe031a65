# SPDX-License-Identifier: GPL-3.0-or-later
"""The results of a measurement: as a text with an aligned table, as JSON, and as a few lines for the panel."""

import json
from pathlib import Path

import bpy

from ..display import edge_stretch_colours
from ..files.atomic_write import atomic_write
from .measurement import Measurement, Row

# (heading, decimals) by attribute of `_sinew.SkinQuality`, in the order of the table
_QUANTITIES = {
    "union": ("union", 3),
    "overlap": ("overlap", 3),
    "volume": ("signed", 3),
    "edge_p50": ("edge p50", 2),
    "edge_p99": ("edge p99", 2),
    "edge_max": ("edge max", 1),
    "area_p99": ("area p99", 2),
    "inverted": ("inverted", 0),
    "new_intersections": ("new intersections", 0),
    "bend_p99": ("bend p99", 1),
}
# keys of the JSON format that differ from the attribute
_JSON_KEYS = {"new_intersections": "new_hits"}
_LEGEND = """\
union: occupied volume over rest volume, with overlaps counted once (1: as at rest). overlap: volume that is occupied twice,
over rest volume. signed: signed volume over rest volume; it counts folds twice. edge, area: max(now / rest, rest / now).
inverted: faces whose normal opposes the skin around them. new intersections: pairs of triangles that intersect in the pose
but not at rest. bend: change of the angle between neighbouring faces, degrees. p50, p99: 50th and 99th percentile.
"""


def text_of(measurement: Measurement) -> str:
    """The whole report as text."""
    widths = {name: max(len(heading), 8) for name, (heading, _) in _QUANTITIES.items()}
    label = max(len(row.deformer) for row in measurement.rows) + 2
    heading = " " * label + "  ".join(f"{_QUANTITIES[name][0]:>{width}}" for name, width in widths.items())
    lines = [f"Quality of {measurement.skin} on {measurement.rig}", "", *_worst_lines(measurement), ""]
    for (pose, region), rows in _by_region(measurement).items():
        lines += ["", f"{pose}, {region}", heading]
        for row in rows:
            lines.append(f"{row.deformer:<{label}}" + "  ".join(f"{_cell(row, name):>{widths[name]}}" for name in widths))
    return "\n".join([*lines, "", _LEGEND])


def numbers_of(measurement: Measurement) -> dict:
    """All numbers: the names of skin and rig, and a list of rows. The keys are part of the JSON format."""
    rows = [
        {"pose": row.pose, "region": row.region, "deformer": row.deformer}
        | {_JSON_KEYS.get(name, name): getattr(row.quality, name) for name in (*_QUANTITIES, "inside_out", "unreadable")}
        for row in measurement.rows
    ]
    return {"skin": measurement.skin, "rig": measurement.rig, "rows": rows}


def json_of(measurement: Measurement) -> str:
    """`numbers_of` as JSON."""
    return json.dumps(numbers_of(measurement), indent=1)


def summary_of(measurement: Measurement) -> list[str]:
    """The worst pose and the quality under each deformer there, in lines that fit the sidebar."""
    worst = measurement.worst()
    rows = [
        f"{row.deformer}: volume {row.quality.union:.3f}, edges x{row.quality.edge_p99:.2f}, "
        f"{row.quality.inverted} inverted, {row.quality.new_intersections} intersections"
        for row in _by_region(measurement)[worst.pose, worst.region]
    ]
    return [f"Worst: {worst.pose}, {worst.region}", *rows]


def write_text(name: str, present, content: str):
    """A text datablock with this content: `present` with its content replaced, or a new one if that is None."""
    text = present or bpy.data.texts.new(name)
    text.clear()
    text.write(content)
    return text


def write_file(path: str, content: str):
    """Writes a file at a path that may be relative to the blend file. Raises NotWritten."""
    with atomic_write(Path(bpy.path.abspath(path))) as file:
        file.write(content.encode())


def remove(skin):
    """Removes the stored measurements of a skin: its texts and its heat map."""
    for text in (skin.sinew.skin.quality_text, skin.sinew.skin.quality_json):
        if text:
            bpy.data.texts.remove(text)
    edge_stretch_colours.remove(skin.data)


def _by_region(measurement: Measurement) -> dict[tuple[str, str], list[Row]]:
    """The rows of each (pose, region), one per deformer."""
    regions: dict[tuple[str, str], list[Row]] = {}
    for row in measurement.rows:
        regions.setdefault((row.pose, row.region), []).append(row)
    return regions


def _cell(row: Row, name: str) -> str:
    return f"{getattr(row.quality, name):.{_QUANTITIES[name][1]}f}"


def _worst_lines(measurement: Measurement) -> list[str]:
    """The summary, then for each quantity the worst pose of the first deformer."""
    first = measurement.rows[0].deformer
    rows = [row for row in measurement.rows if row.deformer == first]
    lines = [*summary_of(measurement), "", f"Worst of {first}, by quantity:"]
    for name, (heading, _decimals) in _QUANTITIES.items():
        at_rest = 1.0 if name in ("union", "volume") else 0.0
        row = max(rows, key=lambda row: abs(getattr(row.quality, name) - at_rest))
        lines.append(f"  {heading:<9}{_cell(row, name):>9}  {row.pose}, {row.region}")
    return lines
