# SPDX-License-Identifier: GPL-3.0-or-later
"""A rig's bones as the segments of a body, each with a frame that is mirrored between left and right.

Armature space, rest pose: independent of the armature object's transform and of how it is posed now.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace

from bpy.types import Object
from mathutils import Vector

from ..errors import SinewError
from .naming import CENTRAL_ROLES, SCHEMES, SIDED_ROLES, SIDES, Chain, Scheme

STRAIGHT_ELBOW_RAD = math.radians(5)
SHORTEST_SEGMENT_M = 1e-5


@dataclass(frozen=True)
class Segment:
    """One anatomical segment: an upper arm, a shin, the pelvis.

    `front` is an arm's flexor side (where the elbow bends to), a hand's palm, a foot's back, else the body's front;
    `outer` looks away from the middle of the body, a shoulder girdle's up. Both are unit and square to `axis`.
    """

    role: str
    side: str
    bones: tuple[str, ...]
    bone_starts: tuple[float, ...]
    start: Vector
    end: Vector
    axis: Vector
    front: Vector
    outer: Vector

    @property
    def length(self) -> float:
        """Metres from start to end."""
        return (self.end - self.start).length

    def point(self, along: float) -> Vector:
        """The point at a fraction of the length, 0 at the start; below 0 and beyond 1 the axis goes on."""
        return self.start.lerp(self.end, along)

    def direction(self, around_deg: float) -> Vector:
        """Square to the axis: 0 front, 90 outer, 180 back, 270 inner."""
        angle = math.radians(around_deg)
        return self.front * math.cos(angle) + self.outer * math.sin(angle)

    def along(self, point: Vector) -> float:
        """The fraction of the length at which a point lies, seen square to the axis."""
        return (point - self.start).dot(self.axis) / self.length

    def bone_at(self, along: float) -> str:
        """The real bone that carries the segment at a fraction of its length (split bones share it)."""
        return [bone for bone, start in zip(self.bones, self.bone_starts, strict=True) if start <= max(along, 0.0)][-1]


@dataclass(frozen=True)
class Body:
    """The segments of one rig."""

    scheme: str
    segments: Mapping[tuple[str, str], Segment]

    def segment(self, role: str, side: str) -> Segment:
        """A segment as one side sees it: of the pelvis and chest, 'R' sees the mirror image of what 'L' sees."""
        if role not in CENTRAL_ROLES:
            return self.segments[role, side]
        central = self.segments[role, ""]
        return replace(central, outer=-central.outer) if side == "R" else central


@dataclass(frozen=True)
class _Line:
    """A segment before its frame is known."""

    role: str
    side: str
    bones: tuple[str, ...]
    heads: tuple[Vector, ...]
    start: Vector
    end: Vector

    @property
    def axis(self) -> Vector:
        return (self.end - self.start).normalized()

    def framed(self, front: Vector, outer: Vector) -> Segment:
        length = (self.end - self.start).length
        inner_starts = ((head - self.start).dot(self.axis) / length for head in self.heads[1:])
        return Segment(
            role=self.role,
            side=self.side,
            bones=self.bones,
            bone_starts=(0.0, *inner_starts),
            start=self.start,
            end=self.end,
            axis=self.axis,
            front=front,
            outer=outer,
        )


def recognise(rig: Object) -> Body:
    """Find the body's segments among a rig's bones, by their names."""
    if rig is None or rig.type != "ARMATURE":
        what = "nothing" if rig is None else f"'{rig.name}' ({rig.type.lower()})"
        raise SinewError(f"An armature is needed to find arms and legs, not {what}: select one, or its mesh")
    scheme = _best_scheme(rig)
    lines = {(role, side): _line(rig, scheme, role, side) for role, side in _places()}
    lines["pelvis", ""] = _pelvis_from_hips(lines)
    _check_lengths(rig, lines)
    return Body(scheme=scheme.label, segments=_framed(rig, scheme, lines))


def _places() -> list[tuple[str, str]]:
    central = [(role, "") for role in CENTRAL_ROLES]
    return central + [(role, side) for role in SIDED_ROLES for side in SIDES]


def _best_scheme(rig: Object) -> Scheme:
    """The scheme that the rig lacks the fewest bones of; all are needed."""
    missing = {scheme.label: _missing(rig, scheme) for scheme in SCHEMES}
    best = min(SCHEMES, key=lambda scheme: len(missing[scheme.label]))
    if not missing[best.label]:
        return best
    known = ", ".join(scheme.label for scheme in SCHEMES)
    if len(missing[best.label]) > len(_places()) // 2:
        raise SinewError(
            f"'{rig.name}' isn't a rig that Sinew knows (it knows: {known}): "
            "rename its bones to one of these, or add muscles by hand with Add Tissue"
        )
    role, side, bone = missing[best.label][0]
    place = f"{_in_words(role)} {side}".strip()
    raise SinewError(
        f"'{rig.name}' looks like {best.label}, but its {place} is missing: there is no bone '{bone}' (rigs known: "
        f"{known}). Give the bone that name again, or add muscles by hand with Add Tissue"
    )


def _missing(rig: Object, scheme: Scheme) -> list[tuple[str, str, str]]:
    wanted = ((role, side, name) for role, side in _places() for name in _names(scheme, role, side))
    return [(role, side, name) for role, side, name in wanted if name not in rig.data.bones]


def _names(scheme: Scheme, role: str, side: str) -> list[str]:
    return [_sided(scheme, name, side) for name in scheme.chains[role].bones]


def _sided(scheme: Scheme, name: str, side: str) -> str:
    return name.replace("{side}", scheme.sides.get(side, ""))


def _in_words(role: str) -> str:
    return role.replace("_", " ")


def _line(rig: Object, scheme: Scheme, role: str, side: str) -> _Line:
    chain = scheme.chains[role]
    bones = [rig.data.bones[name] for name in _names(scheme, role, side)]
    landmarks = [rig.data.bones.get(_sided(scheme, name, side)) for name in chain.ends]
    ends = [bone.head_local for bone in landmarks if bone is not None] or [bones[-1].tail_local]
    return _Line(
        role=role,
        side=side,
        bones=tuple(bone.name for bone in bones),
        heads=tuple(bone.head_local.copy() for bone in bones),
        start=bones[0].head_local.copy(),
        end=sum(ends, Vector()) / len(ends),
    )


def _pelvis_from_hips(lines: Mapping[tuple[str, str], _Line]) -> _Line:
    """Rigs put their root bone anywhere; the two hip joints stand where anatomy has them."""
    hips = [lines["thigh", side].start for side in SIDES]
    return replace(lines["pelvis", ""], start=(hips[0] + hips[1]) / 2)


def _check_lengths(rig: Object, lines: Mapping[tuple[str, str], _Line]) -> None:
    for line in lines.values():
        if (line.end - line.start).length < SHORTEST_SEGMENT_M:
            raise SinewError(
                f"'{rig.name}': the {_in_words(line.role)} {line.side} ('{line.bones[0]}') has no length; "
                "move its end in the armature's Edit Mode"
            )


def _framed(rig: Object, scheme: Scheme, lines: Mapping[tuple[str, str], _Line]) -> dict[tuple[str, str], Segment]:
    up = lines["pelvis", ""].axis
    front = _body_front(lines, up)
    left = up.cross(front)
    segments = {}
    for (role, side), line in lines.items():
        if role in CENTRAL_ROLES:
            own_front = _square(front, line.axis, instead=up)
            outer = _square(left, line.axis, instead=up)
            segments[role, side] = line.framed(own_front, _square(outer, own_front, instead=up))
            continue
        own_front = _sided_front(rig, scheme, lines, line, front=front, up=up)
        outer = own_front.cross(line.axis) if side == "L" else line.axis.cross(own_front)
        segments[role, side] = line.framed(own_front, outer)
    return segments


def _body_front(lines: Mapping[tuple[str, str], _Line], up: Vector) -> Vector:
    """Where the feet point; on tiptoe, square to the line between the hips."""
    feet = sum((lines["foot", side].axis for side in SIDES), Vector())
    hips = lines["thigh", "L"].start - lines["thigh", "R"].start
    return _square(feet, up, instead=hips.cross(up))


def _sided_front(
    rig: Object,
    scheme: Scheme,
    lines: Mapping[tuple[str, str], _Line],
    line: _Line,
    *,
    front: Vector,
    up: Vector,
) -> Vector:
    side = line.side
    if line.role == "foot":
        return _square(up, line.axis, instead=-front)
    if line.role == "hand":
        return _palm(rig, scheme, line) or _elbow_front(lines, side, line.axis, front=front, up=up, above=False)
    if line.role in ("upper_arm", "forearm"):
        return _elbow_front(lines, side, line.axis, front=front, up=up, above=line.role == "upper_arm")
    return _square(front, line.axis, instead=up)


def _elbow_front(
    lines: Mapping[tuple[str, str], _Line], side: str, axis: Vector, *, front: Vector, up: Vector, above: bool
) -> Vector:
    """The flexor side, told by the bend that the elbow has at rest, else the body's front."""
    upper, lower = lines["upper_arm", side].axis, lines["forearm", side].axis
    if upper.angle(lower) < STRAIGHT_ELBOW_RAD:
        return _square(front, axis, instead=up)
    return _square(lower if above else -upper, axis, instead=front)


def _palm(rig: Object, scheme: Scheme, line: _Line) -> Vector | None:
    """Where the palm looks, from the two edges of the hand; nothing where the rig has no fingers."""
    chain: Chain = scheme.chains["hand"]
    edges = [rig.data.bones.get(_sided(scheme, name, line.side)) for name in (chain.thumb_side, chain.little_side)]
    if None in edges:
        return None
    across = edges[1].head_local - edges[0].head_local
    palm = across.cross(line.axis) if line.side == "L" else line.axis.cross(across)
    return palm.normalized() if palm.length > SHORTEST_SEGMENT_M else None


def _square(direction: Vector, axis: Vector, *, instead: Vector) -> Vector:
    """The part of a direction square to an axis, normalised; of another one where the two are nearly parallel."""
    for candidate in (direction.normalized(), instead.normalized()):
        part = candidate - axis * candidate.dot(axis)
        if part.length > 0.1:
            return part.normalized()
    return axis.orthogonal().normalized()
