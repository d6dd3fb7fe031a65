# SPDX-License-Identifier: GPL-3.0-or-later
"""Presets: muscles as fractions of a body, in JSON. A stranger's file is data: read, checked, never run.

What a file may hold stands in presets/schema.json, which anyone's editor can use; a fault names the file, the line, the
tissue and the field.
"""

import functools
import json
import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import fastjsonschema

from ....errors import SinewError
from ....files import json_lines

FOLDER = Path(__file__).resolve().parents[3] / "presets"
SCHEMA = FOLDER / "schema.json"
FIRST = "human"  # what one click adds
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
LONGEST_TENDONS = 0.9
MUSCLE, BONE = "MUSCLE", "BONE"


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
class SpanRule:
    """A muscle or a bone: an ellipsoid between two points.

    Tendons are fractions of the whole length; the width is a fraction of the belly's length. `via` are points that the
    path runs through, `lift` how far the straight belly is brought out toward the skin (0 as it lies, 1 just under the
    skin): a sheet over the ribs is no straight line between its ends; `wraps` the names of the spheres (without their side) that it bends around, `belly` the muscle
    that this is a strand of.
    """

    name: str
    group: str
    sides: tuple[str, ...]
    kind: str
    origin: Attachment
    insertion: Attachment
    width_ratio: float
    thickness_ratio: float
    origin_tendon: float = 0.0
    insertion_tendon: float = 0.0
    volume_keeping: float = 1.0
    lift: float = 0.0
    via: tuple[Attachment, ...] = ()
    wraps: tuple[str, ...] = ()
    belly: str = ""

    @property
    def attachments(self) -> tuple[Attachment, ...]:
        """Origin, via points, insertion."""
        return (self.origin, *self.via, self.insertion)

    @property
    def roles(self) -> frozenset[str]:
        """The segments that a body needs for it."""
        return frozenset(role for at in self.attachments for role in (at.segment, at.carried_by))


@dataclass(frozen=True)
class StuffingRule:
    """A rigid ellipsoid that fills a segment from one share of its length to another, to a share of the skin's width."""

    name: str
    group: str
    sides: tuple[str, ...]
    segment: str
    start: float
    end: float
    width: float

    @property
    def roles(self) -> frozenset[str]:
        """The segments that a body needs for it."""
        return frozenset({self.segment})


@dataclass(frozen=True)
class SphereRule:
    """A rigid sphere in a joint; its radius is a fraction of the distance to the skin there."""

    name: str
    group: str
    sides: tuple[str, ...]
    joint: str
    radius: float

    @property
    def roles(self) -> frozenset[str]:
        """The segments that a body needs for it."""
        return frozenset({JOINTS[self.joint][0]})


Rule = SpanRule | StuffingRule | SphereRule


@dataclass(frozen=True)
class Preset:
    """A preset file, checked."""

    name: str
    description: str
    sources: Mapping[str, str]
    tissues: tuple[Rule, ...]

    @property
    def roles(self) -> frozenset[str]:
        """The segments that a body needs for all of it."""
        return frozenset().union(*(rule.roles for rule in self.tissues))

    @property
    def has_strands(self) -> bool:
        """Whether some of its muscles come in strands that can be joined."""
        return any(isinstance(rule, SpanRule) and rule.belly for rule in self.tissues)


@functools.cache
def available() -> list[tuple[str, str, str]]:
    """The presets that Sinew ships, as an EnumProperty wants them: identifier, label, description."""
    heads = {path.stem: json.loads(path.read_text(encoding="utf-8")) for path in _shipped()}
    return [(identifier, head["name"], head["description"]) for identifier, head in heads.items()]


def read(source: str | Path) -> Preset:
    """A shipped preset by its identifier ("limbs"), or anyone's by its path. Raises SinewError at the first fault."""
    path = Path(source)
    if isinstance(source, str) and not path.suffix and len(path.parts) == 1:
        path = FOLDER / f"{source}.json"
        if path not in _shipped():
            known = ", ".join(shipped.stem for shipped in _shipped())
            raise SinewError(f"There is no preset '{source}': Sinew has {known}")
    text = _text(path)
    data = _parsed(text, path.name)
    _check(data, text, path.name)
    return _preset(data)


def _shipped() -> list[Path]:
    found = sorted(path for path in FOLDER.glob("*.json") if path != SCHEMA)
    return sorted(found, key=lambda path: path.stem != FIRST)


def _text(path: Path) -> str:
    try:
        if path.stat().st_size > LARGEST_FILE_BYTES:
            raise SinewError(f"{path.name}: too large for a preset (more than {LARGEST_FILE_BYTES // 1_000_000} MB)")
        return path.read_text(encoding="utf-8")
    except OSError as error:
        raise SinewError(f"{path.name}: can't be read ({error.strerror}): choose another file") from error
    except UnicodeDecodeError as error:
        raise SinewError(f"{path.name}: not a JSON file in UTF-8 ({error.reason})") from error


def _parsed(text: str, file_name: str) -> Any:
    try:
        return json_lines.parse(text)
    except json_lines.Fault as fault:
        raise SinewError(f"{file_name}, line {fault.line}: {fault}") from fault


@functools.cache
def _validator():
    return fastjsonschema.compile(json.loads(SCHEMA.read_text(encoding="utf-8")))


def _check(data: Any, text: str, file_name: str) -> None:
    try:
        _validator()(data)
    except fastjsonschema.JsonSchemaValueException as fault:
        # the library's path names are made for its own messages: "data.tissues[3].origin" is ["data", "tissues", "3", ...]
        raise _fault(fault.path[1:], fault.message.removeprefix(fault.name).strip(), data, text, file_name) from fault
    names: dict[str, int] = {}
    spheres = {tissue["name"] for tissue in data["tissues"] if tissue["kind"] == "SPHERE"}
    for index, tissue in enumerate(data["tissues"]):
        problem = _problem(tissue, data, names, spheres)
        if problem:
            field, what = problem
            raise _fault(["tissues", str(index), field], what, data, text, file_name)
        names[tissue["name"]] = index


def _problem(tissue: Mapping, data: Mapping, names: Mapping[str, int], spheres: set[str]) -> tuple[str, str] | None:
    """What a schema can't say: (field, what is wrong with it)."""
    name = tissue["name"]
    if name in names:
        return "name", f"is used twice: tissues {names[name] + 1} and {len(names) + 1}"
    if len(name.encode()) > LONGEST_NAME_BYTES:
        return "name", f"is longer than {LONGEST_NAME_BYTES} bytes"
    if tissue["group"] not in data["sources"]:
        return "group", f"must be one of those in 'sources': {', '.join(data['sources'])}"
    if tissue.get("origin_tendon", 0.0) + tissue.get("insertion_tendon", 0.0) > LONGEST_TENDONS:
        return "insertion_tendon", f"and 'origin_tendon' together leave no belly: at most {LONGEST_TENDONS}"
    for wrap in tissue.get("wraps", ()):
        if wrap not in spheres:
            return "wraps", f"names '{wrap}', which is no SPHERE of this file"
    return None


def _fault(path: list[str], what: str, data: Any, text: str, file_name: str) -> SinewError:
    line = json_lines.line_of(text, path)
    named = ""
    if len(path) > 1 and path[0] == "tissues" and path[1].isdigit():
        tissue = data["tissues"][int(path[1])]
        own_name = tissue.get("name") if isinstance(tissue, dict) else None
        named = own_name if isinstance(own_name, str) and own_name else f"tissue {int(path[1]) + 1}"
        path = path[2:]
    field = f"'{'.'.join(path)}' " if path else ""
    return SinewError(f"{file_name}, line {line}: {f'{named}: ' if named else ''}{field}{what}")


def _preset(data: Mapping) -> Preset:
    return Preset(data["name"], data["description"], data["sources"], tuple(map(_rule, data["tissues"])))


def _rule(tissue: Mapping) -> Rule:
    same = {"name": tissue["name"], "group": tissue["group"], "sides": tuple(tissue["sides"])}
    if tissue["kind"] == "SPHERE":
        return SphereRule(**same, joint=tissue["joint"], radius=tissue["radius"])
    if tissue["kind"] == "STUFFING":
        return StuffingRule(
            **same, segment=tissue["segment"], start=tissue["start"], end=tissue["end"], width=tissue["width"]
        )
    optional = {key: tissue[key] for key in ("origin_tendon", "insertion_tendon", "volume_keeping", "lift") if key in tissue}
    return SpanRule(
        **same,
        **optional,
        kind=tissue["kind"],
        origin=_attachment(tissue["origin"]),
        insertion=_attachment(tissue["insertion"]),
        width_ratio=tissue["width_ratio"],
        thickness_ratio=tissue["thickness_ratio"],
        via=tuple(map(_attachment, tissue.get("via", ()))),
        wraps=tuple(tissue.get("wraps", ())),
        belly=tissue.get("belly", ""),
    )


def _attachment(at: Mapping) -> Attachment:
    carried_by = at.get("carried_by", at["segment"])
    return Attachment(at["segment"], at["along"], math.fmod(at["around"], 360.0), at["depth"], carried_by)
