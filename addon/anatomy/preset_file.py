# SPDX-License-Identifier: GPL-3.0-or-later
"""Presets: muscles as fractions of a body, in JSON. A stranger's file is data: read, checked, never run.

Each fault names the file, the tissue and the field, and what would be right there.
"""

import json
import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ..errors import SinewError
from .naming import ROLES, SIDES

FOLDER = Path(__file__).resolve().parent.parent / "presets"
FORMAT = 1
JOINTS = {
    "shoulder": ("upper_arm", 0.0),
    "elbow": ("upper_arm", 1.0),
    "wrist": ("forearm", 1.0),
    "hip": ("thigh", 0.0),
    "knee": ("thigh", 1.0),
    "ankle": ("shin", 1.0),
}
LONGEST_NAME_BYTES = 58  # an object's name has 63 bytes; the side and Blender's ".001" want room
LARGEST_FILE_BYTES = 4_000_000


@dataclass(frozen=True)
class Attachment:
    """A point by its place on a segment: along it, around it, and how deep between its axis (0) and the skin (1).

    `carried_by` is the segment that it moves with: near a joint, a point is often best told from the next segment.
    """

    segment: str
    along: float
    around_deg: float
    depth: float
    carried_by: str


@dataclass(frozen=True)
class MuscleRule:
    """A muscle. Tendons are fractions of its whole length; the belly's width is a fraction of the belly's length."""

    name: str
    group: str
    sides: tuple[str, ...]
    origin: Attachment
    insertion: Attachment
    origin_tendon: float
    insertion_tendon: float
    width_ratio: float
    thickness_ratio: float
    volume_keeping: float


@dataclass(frozen=True)
class SphereRule:
    """A rigid sphere in a joint; its radius is a fraction of the distance to the skin there."""

    name: str
    group: str
    sides: tuple[str, ...]
    joint: str
    radius: float


@dataclass(frozen=True)
class Preset:
    """A preset file, checked."""

    name: str
    description: str
    sources: Mapping[str, str]
    tissues: tuple[MuscleRule | SphereRule, ...]


def available() -> list[tuple[str, str, str]]:
    """The presets that Sinew ships, as an EnumProperty wants them: identifier, label, description."""
    presets = [(path.stem, read(path)) for path in sorted(FOLDER.glob("*.json"))]
    return [(identifier, preset.name, preset.description) for identifier, preset in presets]


def read(source: str | Path) -> Preset:
    """A shipped preset by its identifier ("limbs"), or anyone's by its path."""
    path = Path(source)
    if isinstance(source, str) and not path.suffix and len(path.parts) == 1:
        path = FOLDER / f"{source}.json"
        if not path.is_file():
            known = ", ".join(sorted(shipped.stem for shipped in FOLDER.glob("*.json")))
            raise SinewError(f"There is no preset '{source}': Sinew has {known}")
    return _preset(_Table(_parsed(path), path.name))


def _parsed(path: Path) -> Any:
    try:
        if path.stat().st_size > LARGEST_FILE_BYTES:
            raise SinewError(f"{path.name}: too large for a preset (more than {LARGEST_FILE_BYTES // 1_000_000} MB)")
        return json.loads(path.read_text(encoding="utf-8"), object_pairs_hook=_without_twins)
    except OSError as error:
        raise SinewError(f"{path.name}: can't be read ({error.strerror}): choose another file") from error
    except json.JSONDecodeError as error:
        raise SinewError(f"{path.name}, line {error.lineno}: not JSON ({error.msg})") from error
    except (ValueError, RecursionError) as error:
        raise SinewError(f"{path.name}: not a JSON file in UTF-8 ({error})") from error


def _without_twins(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    table = dict(pairs)
    if len(table) < len(pairs):
        names = [name for name, _ in pairs]
        twin = next(name for name in names if names.count(name) > 1)
        raise ValueError(f"'{twin}' stands twice in one object")
    return table


class _Table:
    """A JSON object that is read field by field; `finish` finds the fields that nothing read."""

    def __init__(self, value: Any, place: str) -> None:
        if not isinstance(value, dict):
            raise SinewError(f"{place}: expected an object in braces, found {_shown(value)}")
        self.place = place
        self._value = value
        self._read: set[str] = set()

    def fault(self, field: str, what: str) -> SinewError:
        return SinewError(f"{self.place}: '{field}' {what}")

    def has(self, field: str) -> bool:
        return field in self._value

    def get(self, field: str) -> Any:
        self._read.add(field)
        if field not in self._value:
            raise self.fault(field, "is missing")
        return self._value[field]

    def table(self, field: str) -> "_Table":
        return _Table(self.get(field), f"{self.place}: {field}")

    def tables(self, field: str) -> list["_Table"]:
        value = self.get(field)
        if not isinstance(value, list) or not value:
            raise self.fault(field, f"must be a list with something in it, not {_shown(value)}")
        return [_Table(entry, f"{self.place}: {field} {number}") for number, entry in enumerate(value, 1)]

    def text(self, field: str) -> str:
        value = self.get(field)
        if not isinstance(value, str) or not value.strip():
            raise self.fault(field, f"must be a text, not {_shown(value)}")
        return value

    def texts(self, field: str) -> dict[str, str]:
        table = self.table(field)
        return {name: table.text(name) for name in table._value}

    def one_of(self, field: str, known: tuple[str, ...]) -> str:
        value = self.get(field)
        if not isinstance(value, str) or value not in known:
            raise self.fault(field, f"must be one of {', '.join(known)}, not {_shown(value)}")
        return value

    def number(self, field: str, low: float, high: float) -> float:
        value = self.get(field)
        is_number = isinstance(value, int | float) and not isinstance(value, bool)
        if not is_number or not math.isfinite(value) or not low <= value <= high:
            raise self.fault(field, f"must be a number from {low:g} to {high:g}, not {_shown(value)}")
        return float(value)

    def finish(self) -> None:
        unknown = sorted(set(self._value) - self._read)
        if unknown:
            raise self.fault(unknown[0], "is not a field that Sinew knows here")


def _shown(value: Any) -> str:
    text = json.dumps(value)
    return text if len(text) <= 40 else f"{text[:37]}..."


def _preset(table: _Table) -> Preset:
    if table.get("sinew_preset") != FORMAT:
        raise table.fault("sinew_preset", f"must be {FORMAT}: this Sinew reads no other format")
    sources = table.texts("sources")
    tissues = tuple(_tissue(entry, table.place, tuple(sources)) for entry in table.tables("tissues"))
    preset = Preset(table.text("name"), table.text("description"), sources, tissues)
    table.finish()
    names = [tissue.name for tissue in tissues]
    for name in names:
        if names.count(name) > 1:
            raise table.fault("tissues", f"names '{name}' twice")
    return preset


def _tissue(table: _Table, file_name: str, groups: tuple[str, ...]) -> MuscleRule | SphereRule:
    name = table.text("name")
    if len(name.encode()) > LONGEST_NAME_BYTES:
        raise table.fault("name", f"is longer than {LONGEST_NAME_BYTES} bytes: {_shown(name)}")
    table.place = f"{file_name}: {name}"
    kind = table.one_of("kind", ("MUSCLE", "SPHERE"))
    group = table.one_of("group", groups)
    rule = _muscle(table, name, group) if kind == "MUSCLE" else _sphere(table, name, group)
    table.finish()
    return rule


def _sides(table: _Table) -> tuple[str, ...]:
    value = table.get("sides")
    if value not in (["L"], ["R"], ["L", "R"]):
        raise table.fault("sides", f'must be ["L"], ["R"] or ["L", "R"], not {_shown(value)}')
    return tuple(side for side in SIDES if side in value)


def _muscle(table: _Table, name: str, group: str) -> MuscleRule:
    rule = MuscleRule(
        name=name,
        group=group,
        sides=_sides(table),
        origin=_attachment(table.table("origin")),
        insertion=_attachment(table.table("insertion")),
        origin_tendon=table.number("origin_tendon", 0.0, 0.9),
        insertion_tendon=table.number("insertion_tendon", 0.0, 0.9),
        width_ratio=table.number("width_ratio", 0.01, 3.0),
        thickness_ratio=table.number("thickness_ratio", 0.05, 5.0),
        volume_keeping=table.number("volume_keeping", 0.0, 1.5),
    )
    if rule.origin_tendon + rule.insertion_tendon > 0.9:
        raise table.fault("insertion_tendon", "and 'origin_tendon' together leave no belly: at most 0.9 of the length")
    return rule


def _sphere(table: _Table, name: str, group: str) -> SphereRule:
    return SphereRule(
        name=name,
        group=group,
        sides=_sides(table),
        joint=table.one_of("joint", tuple(JOINTS)),
        radius=table.number("radius", 0.01, 1.0),
    )


def _attachment(table: _Table) -> Attachment:
    segment = table.one_of("segment", ROLES)
    attachment = Attachment(
        segment=segment,
        along=table.number("along", -1.0, 2.0),
        around_deg=table.number("around", 0.0, 360.0),
        depth=table.number("depth", 0.0, 1.0),
        carried_by=table.one_of("carried_by", ROLES) if table.has("carried_by") else segment,
    )
    table.finish()
    return attachment
