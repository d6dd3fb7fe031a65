# SPDX-License-Identifier: GPL-3.0-or-later
"""What a measurement found, as a text with an aligned table, as JSON, and as a few lines for the panel."""

import json
from pathlib import Path

import bpy

from ..display import strain_colours
from ..files.atomic_write import atomic_write
from .measurement import Measurement, Row

# heading, decimals; in the table's order
_QUANTITIES = {
    "union": ("union", 3),
    "overlap": ("overlap", 3),
    "volume": ("signed", 3),
    "edge_p50": ("edge p50", 2),
    "edge_p99": ("edge p99", 2),
    "edge_max": ("edge max", 1),
    "area_p99": ("area p99", 2),
    "inverted": ("inverted", 0),
    "new_hits": ("new hits", 0),
    "bend_p99": ("bend p99", 1),
}
_LEGEND = """\
union: volume really occupied over rest (1 is as at rest). overlap: volume occupied twice, over rest. signed: signed volume
over rest; it counts folds twice. edge, area: max(now / rest, rest / now). inverted: faces that point against the skin
around them. new hits: pairs of triangles that cut each other and did not at rest. bend: change of the angle between
neighbouring faces, degrees. p50, p99: what 50 and 99 of 100 do not exceed.
"""


def text_of(measurement: Measurement) -> str:
    """The whole report."""
    widths = {name: max(len(heading), 8) for name, (heading, _) in _QUANTITIES.items()}
    label = max(len(row.deformer) for row in measurement.rows) + 2
    heading = " " * label + "  ".join(f"{_QUANTITIES[name][0]:>{width}}" for name, width in widths.items())
    lines = [f"Quality of {measurement.skin} on {measurement.rig}", "", *_worst_lines(measurement), ""]
    for (pose, region), rows in _by_place(measurement).items():
        lines += ["", f"{pose}, {region}", heading]
        for row in rows:
            lines.append(f"{row.deformer:<{label}}" + "  ".join(f"{_cell(row, name):>{widths[name]}}" for name in widths))
    return "\n".join([*lines, "", _LEGEND])


def numbers_of(measurement: Measurement) -> dict:
    """All numbers: the names of skin and rig, and a list of rows."""
    rows = [
        {"pose": row.pose, "region": row.region, "deformer": row.deformer}
        | {name: getattr(row.quality, name) for name in (*_QUANTITIES, "inside_out", "unreadable")}
        for row in measurement.rows
    ]
    return {"skin": measurement.skin, "rig": measurement.rig, "rows": rows}


def json_of(measurement: Measurement) -> str:
    """`numbers_of` as JSON."""
    return json.dumps(numbers_of(measurement), indent=1)


def summary_of(measurement: Measurement) -> list[str]:
    """The worst pose, and how each deformer does there, in lines as wide as the sidebar."""
    worst = measurement.worst()
    same = _by_place(measurement)[worst.pose, worst.region]
    told = [
        f"{row.deformer}: volume {row.quality.union:.3f}, edges x{row.quality.edge_p99:.2f}, "
        f"{row.quality.inverted} inverted, {row.quality.new_hits} hits"
        for row in same
    ]
    return [f"Worst: {worst.pose}, {worst.region}", *told]


def write_text(name: str, present, content: str):
    """A text datablock with this content: `present`, or a new one."""
    text = present or bpy.data.texts.new(name)
    text.clear()
    text.write(content)
    return text


def write_file(path: str, content: str):
    """Writes a file where the person said. Raises NotWritten where that can't be done."""
    with atomic_write(Path(bpy.path.abspath(path))) as file:
        file.write(content.encode())


def remove(skin):
    """Takes everything that was kept of a skin's measurements away."""
    for text in (skin.sinew.quality_text, skin.sinew.quality_json):
        if text:
            bpy.data.texts.remove(text)
    strain_colours.remove(skin.data)


def _by_place(measurement: Measurement) -> dict[tuple[str, str], list[Row]]:
    """The rows of each pose and region, one a deformer."""
    places: dict[tuple[str, str], list[Row]] = {}
    for row in measurement.rows:
        places.setdefault((row.pose, row.region), []).append(row)
    return places


def _cell(row: Row, name: str) -> str:
    return f"{getattr(row.quality, name):.{_QUANTITIES[name][1]}f}"


def _worst_lines(measurement: Measurement) -> list[str]:
    """For each quantity the pose in which the first deformer does worst."""
    first = measurement.rows[0].deformer
    own = [row for row in measurement.rows if row.deformer == first]
    lines = [*summary_of(measurement), "", f"Worst of {first}, by quantity:"]
    for name, (heading, _decimals) in _QUANTITIES.items():
        from_rest = 1.0 if name in ("union", "volume") else 0.0
        row = max(own, key=lambda row: abs(getattr(row.quality, name) - from_rest))
        lines.append(f"  {heading:<9}{_cell(row, name):>9}  {row.pose}, {row.region}")
    return lines
