# SPDX-License-Identifier: GPL-3.0-or-later
"""Presets: muscles as fractions of a body, read from JSON and checked field by field.

presets/schema.json describes the format for editors and for people; `read` refuses what the schema refuses. An error names
the file, the line, the tissue and the field.
"""

import functools
import json
import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

from ....errors import SinewError
from ....files import strict_json
from ...portable_names import LONGEST_NAME_BYTES
from ..recognise.body_parts import DIGIT_ROLES, ROLES
from ..recognise.kind import KINDS as KINDS_OF_CREATURES

FOLDER = Path(__file__).resolve().parents[3] / "presets"
SCHEMA = FOLDER / "schema.json"
FIRST = "human"  # what one click adds
FORMAT = 1
SEGMENTS = ROLES + DIGIT_ROLES
PROPORTIONS = ("front", "side", "back")
JOINTS = {
    "shoulder": ("upper_arm", 0.0),
    "elbow": ("upper_arm", 1.0),
    "wrist": ("forearm", 1.0),
    "hip": ("thigh", 0.0),
    "knee": ("thigh", 1.0),
    "ankle": ("shin", 1.0),
}
MUSCLE, BONE, STUFFING, SPHERE = KINDS = ("MUSCLE", "BONE", "STUFFING", "SPHERE")
SIDES = (("L", "R"), ("L",), ("R",), ("C",))
LARGEST_FILE_BYTES = 4_000_000
MOST_TISSUES = 2000
MOST_VIA_POINTS = 16
MOST_WRAPS = 8
LONGEST_TEXT = 1000  # characters
LONGEST_TENDONS = 0.9


@dataclass(frozen=True)
class Attachment:
    """A point on a segment of the body.

    along: 0 at the segment's start, 1 at its end. around_deg: degrees around the segment: 0 front, 90 outer, 180 back, 270
    inner. depth: 0 on the segment's axis, 1 at the skin. carried_by: the segment that the point moves with; near a joint,
    the neighbouring segment often describes the position better.
    """

    segment: str
    along: float
    around_deg: float
    depth: float
    carried_by: str


@dataclass(frozen=True)
class SpanRule:
    """A muscle, a bone or stuffing: an ellipsoid between two attachments.

    width_ratio: width over the length of the belly. thickness_ratio: thickness over width. origin_tendon,
    insertion_tendon: fractions of the whole length. lift: how far a straight belly moves towards the skin: 0 not at all, 1
    to just under the skin; a flat muscle over the ribs is not a straight line between its ends. via: points that the
    path passes through. wraps: names of the spheres, without their side, that the path wraps around. belly: the muscle
    that this one is a strand of, or an empty text. volume_cm3: the measured volume on the preset's body, or 0.
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
    volume_cm3: float = 0.0

    @property
    def attachments(self) -> tuple[Attachment, ...]:
        """Origin, via points and insertion, in this order."""
        return (self.origin, *self.via, self.insertion)

    @property
    def roles(self) -> frozenset[str]:
        """The segments that a body needs for this tissue."""
        return frozenset(role for at in self.attachments for role in (at.segment, at.carried_by))


@dataclass(frozen=True)
class StuffingRule:
    """A rigid ellipsoid inside a segment. start, end: fractions of its length. width: fraction of the skin's width there."""

    name: str
    group: str
    sides: tuple[str, ...]
    segment: str
    start: float
    end: float
    width: float

    @property
    def roles(self) -> frozenset[str]:
        """The segments that a body needs for this tissue."""
        return frozenset({self.segment})


@dataclass(frozen=True)
class SphereRule:
    """A rigid sphere at a joint. radius: fraction of the distance from the joint to the skin."""

    name: str
    group: str
    sides: tuple[str, ...]
    joint: str
    radius: float

    @property
    def roles(self) -> frozenset[str]:
        """The segments that a body needs for this tissue."""
        return frozenset({JOINTS[self.joint][0]})


Rule = SpanRule | StuffingRule | SphereRule


@dataclass(frozen=True)
class Preset:
    """A checked preset file.

    sources: where the numbers of each group of tissues come from. creature: the kind that it is for (`kind.KINDS`), or "".
    body_litres: the volume of the body whose muscles have the measured volumes, or 0. fat_mm: the depth of fat over the
    tissues of each group on that body. With both, the tissues fill the body.
    proportions: usual distances from a segment's axis to the skin, for a rig without a mesh, as in `Segment`, by role.
    """

    name: str
    description: str
    sources: Mapping[str, str]
    tissues: tuple[Rule, ...]
    creature: str = ""
    body_litres: float = 0.0
    fat_mm: Mapping[str, float] = field(default_factory=dict)
    proportions: Mapping[str, tuple[float, float, float]] = field(default_factory=dict)

    @property
    def fills(self) -> bool:
        """Whether its tissues fill the body."""
        return self.body_litres > 0.0

    @property
    def roles(self) -> frozenset[str]:
        """The segments that a body needs for the whole preset."""
        return frozenset().union(*(rule.roles for rule in self.tissues))


@functools.cache
def available() -> list[tuple[str, str, str]]:
    """The presets that Sinew ships, as items of an EnumProperty: identifier, label, description."""
    heads = {path.stem: json.loads(path.read_text(encoding="utf-8")) for path in _shipped()}
    return [(identifier, head["name"], head["description"]) for identifier, head in heads.items()]


def picture_of(name: str) -> Path:
    """The thumbnail of a shipped preset, a PNG (`scripts/window/thumbnails.py` draws it)."""
    return FOLDER / "thumbnails" / f"{name}.png"


def read(source: str | Path) -> Preset:
    """A shipped preset by its identifier ("limbs"), or any preset by its path. Raises SinewError at the first error."""
    path = Path(source)
    if isinstance(source, str) and not path.suffix and len(path.parts) == 1:
        path = FOLDER / f"{source}.json"
        if path not in _shipped():
            known = ", ".join(shipped.stem for shipped in _shipped())
            shown = source.encode("utf-8", "backslashreplace").decode()
            raise SinewError(f"There is no preset '{shown}': Sinew has {known}")
    return _preset(strict_json.read(path, LARGEST_FILE_BYTES))


def _shipped() -> list[Path]:
    paths = sorted(path for path in FOLDER.glob("*.json") if path != SCHEMA)
    return sorted(paths, key=lambda path: path.stem != FIRST)


def _preset(table: strict_json.Table) -> Preset:
    if table.get("sinew_preset") != FORMAT:
        raise table.fault("sinew_preset", f"must be {FORMAT}: this version of Sinew reads no other format")
    if table.has("$schema"):
        table.long_text("$schema", LONGEST_TEXT, may_be_empty=True)
    name, description = table.long_text("name", LONGEST_TEXT), table.long_text("description", LONGEST_TEXT)
    creature = table.one_of("creature", KINDS_OF_CREATURES) if table.has("creature") else ""
    groups = table.table("sources")
    sources = {group: groups.long_text(group, LONGEST_TEXT) for group in groups.fields()}
    if not sources:
        raise table.fault("sources", "must name the source of each group of tissues")
    body_litres = table.number("body_litres", 0.001, 100_000) if table.has("body_litres") else 0.0
    fat_mm = _fat_mm(table.table("fat_mm"), sources) if body_litres else {}
    proportions = _proportions(table.table("proportions")) if table.has("proportions") else {}
    entries = table.tables("tissues", MOST_TISSUES, fewest=1)
    table.finish()
    rules: dict[str, Rule] = {}
    for index, entry in enumerate(entries):
        entry.describes(f"tissue {index + 1}")
        rule = _rule(entry, sources)
        if rule.name in rules:
            first = list(rules).index(rule.name) + 1
            raise entry.fault("name", f"is used twice: tissues {first} and {index + 1}")
        rules[rule.name] = rule
    _check_wraps(entries, rules)
    return Preset(name, description, sources, tuple(rules.values()), creature, body_litres, fat_mm, proportions)


def _fat_mm(table: strict_json.Table, sources: Mapping[str, str]) -> dict[str, float]:
    fat_mm = {group: table.number(group, 0, 200) for group in sources}
    table.finish()
    return fat_mm


def _proportions(roles: strict_json.Table) -> dict[str, tuple[float, float, float]]:
    found = {}
    for role in roles.fields():
        if role not in SEGMENTS:
            raise roles.fault(role, f"must be one of {', '.join(SEGMENTS)}")
        distances = roles.table(role)
        front, side, back = (distances.number(name, 0.01, 3) for name in PROPORTIONS)
        distances.finish()
        found[role] = (front, side, back)
    return found


def _check_wraps(entries: list[strict_json.Table], rules: Mapping[str, Rule]):
    """A wrap may name a sphere that follows in the file, so all tissues are read before."""
    for entry, rule in zip(entries, rules.values()):
        for wrap in rule.wraps if isinstance(rule, SpanRule) else ():
            if not isinstance(rules.get(wrap), SphereRule):
                raise entry.fault("wraps", f"names '{wrap}', which is not a SPHERE of this file")


def _rule(tissue: strict_json.Table, sources: Mapping[str, str]) -> Rule:
    name = tissue.text("name", LONGEST_NAME_BYTES)
    tissue.describes(name)
    kind = tissue.one_of("kind", KINDS)
    common = {"name": name, "group": tissue.one_of("group", sources), "sides": _sides(tissue)}
    if kind == SPHERE:
        rule = SphereRule(**common, joint=tissue.one_of("joint", JOINTS), radius=tissue.number("radius", 0.01, 1))
    elif kind == STUFFING and not tissue.has("origin"):
        rule = StuffingRule(
            **common,
            segment=tissue.one_of("segment", SEGMENTS),
            start=tissue.number("start", -3, 3),
            end=tissue.number("end", -3, 3),
            width=tissue.number("width", 0.01, 1),
        )
    else:
        rule = SpanRule(
            **common,
            kind=kind,
            origin=_attachment(tissue.table("origin")),
            insertion=_attachment(tissue.table("insertion")),
            width_ratio=tissue.number("width_ratio", 0.01, 3),
            thickness_ratio=tissue.number("thickness_ratio", 0.05, 5),
            **(_muscle_fields(tissue) if kind == MUSCLE else {}),
        )
    tissue.finish()
    return rule


def _sides(tissue: strict_json.Table) -> tuple[str, ...]:
    sides = tissue.texts("sides")
    if sides not in SIDES:
        raise tissue.fault("sides", f"must be one of {', '.join(json.dumps(list(known)) for known in SIDES)}")
    return sides


def _muscle_fields(tissue: strict_json.Table) -> dict:
    """The fields that only a muscle has; those that may be missing are left out then."""
    fields: dict = {name: tissue.number(name, 0, LONGEST_TENDONS) for name in ("origin_tendon", "insertion_tendon")}
    if sum(fields.values()) > LONGEST_TENDONS:
        raise tissue.fault("insertion_tendon", f"and 'origin_tendon' together leave no belly: at most {LONGEST_TENDONS}")
    for name, high in (("lift", 1), ("volume_keeping", 1.5)):
        if tissue.has(name):
            fields[name] = tissue.number(name, 0, high)
    if tissue.has("volume_cm3"):
        fields["volume_cm3"] = tissue.number("volume_cm3", 0.01, 1_000_000)
    if tissue.has("via"):
        fields["via"] = tuple(map(_attachment, tissue.tables("via", MOST_VIA_POINTS)))
    if tissue.has("wraps"):
        fields["wraps"] = tissue.texts("wraps", MOST_WRAPS)
    if tissue.has("belly"):
        fields["belly"] = tissue.long_text("belly", LONGEST_TEXT)
    return fields


def _attachment(at: strict_json.Table) -> Attachment:
    segment = at.one_of("segment", SEGMENTS)
    attachment = Attachment(
        segment=segment,
        along=at.number("along", -3, 3),
        around_deg=math.fmod(at.number("around", 0, 360), 360.0),
        depth=at.number("depth", 0, 1),
        carried_by=at.one_of("carried_by", SEGMENTS) if at.has("carried_by") else segment,
    )
    at.finish()
    return attachment
