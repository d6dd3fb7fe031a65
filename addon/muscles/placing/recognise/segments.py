# SPDX-License-Identifier: GPL-3.0-or-later
"""A rig's bones as the segments of a body, each with a frame that is mirrored between left and right.

Armature space, rest pose: independent of the armature object's transform and of how it is posed now.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace

from bpy.types import Object
from mathutils import Vector

from ....errors import SinewError
from . import recognition
from .naming import CENTRAL_ROLES, NEXT_ROLE, OPTIONAL_ROLES, SIDES, TRUNK_ROLES, in_words
from .recognition import Place, Recognised

STRAIGHT_ELBOW_RAD = math.radians(5)
SHORTEST_SEGMENT_M = 1e-5
# Where the pelvis and the abdomen end, of the way from the hips to the neck: however many bones a spine has.
TRUNK_ENDS = (0.2, 0.48)
SAME_START = 0.02  # a twist bone that starts where its segment does carries nothing of its own
ON_FOURS = 0.5  # cosine between the trunk and the way from the feet up, below which a body stands on four legs


@dataclass(frozen=True)
class Segment:
    """One anatomical segment: an upper arm, a shin, the pelvis.

    `front` is an arm's flexor side (where the elbow bends to), a hand's palm, a foot's back, a leg's side that the toes
    point to, else the belly's side; `outer` looks away from the middle of the body, a shoulder girdle's up. Both are
    unit and square to `axis`. `on_fours`: the body stands on four legs, which has other proportions.
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
    on_fours: bool

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
    """The segments of one rig, and the bones that they were recognised by."""

    rig_name: str
    recognised: Recognised
    segments: Mapping[Place, Segment]

    @property
    def scheme(self) -> str:
        """The kind of rig, for people."""
        return self.recognised.label

    def has(self, role: str, side: str) -> bool:
        """Whether the rig has this part of a body."""
        return (role, "" if role in CENTRAL_ROLES else side) in self.segments

    def segment(self, role: str, side: str) -> Segment:
        """A segment as one side sees it: of the trunk, head and tail, 'R' sees the mirror image of what 'L' sees.

        Raises SinewError where the rig lacks it, naming the part, the kind of rig and the remedy.
        """
        if not self.has(role, side):
            raise SinewError(self._missing(role, "" if role in CENTRAL_ROLES else side))
        if role not in CENTRAL_ROLES:
            return self.segments[role, side]
        central = self.segments[role, ""]
        return replace(central, outer=-central.outer) if side == "R" else central

    def _missing(self, role: str, side: str) -> str:
        expected = self.recognised.expected.get((role, side))
        why = f"there is no bone '{expected}'" if expected else "no bone was recognised as it"
        return (
            f"'{self.rig_name}' looks like {self.scheme}, but its {in_words(role, side)} is missing: {why}. "
            "Name the bone in the table Bones of this operator, or add muscles by hand with Add Tissue"
        )


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

    def framed(self, front: Vector, outer: Vector, on_fours: bool) -> Segment:
        length = (self.end - self.start).length
        starts = [(head - self.start).dot(self.axis) / length for head in self.heads[1:]]
        carriers = [(0.0, self.bones[0])]
        carriers += sorted(
            (start, bone) for start, bone in zip(starts, self.bones[1:], strict=True) if SAME_START < start < 1.0
        )
        return Segment(
            role=self.role,
            side=self.side,
            bones=tuple(bone for _, bone in carriers),
            bone_starts=tuple(start for start, _ in carriers),
            start=self.start,
            end=self.end,
            axis=self.axis,
            front=front,
            outer=outer,
            on_fours=on_fours,
        )


def recognise(rig: Object, corrections: Mapping[Place, str] | None = None) -> Body:
    """Find the body's segments among a rig's bones: by names, by shape, and as a person corrects the guess.

    corrections: (role, side) to the first bone of that segment; the side of a central role is "".
    """
    recognised = recognition.recognise(rig, corrections)
    for role, side in (("thigh", "L"), ("thigh", "R")):
        if (role, side) not in recognised.chains:
            raise SinewError(Body(rig.name, recognised, {})._missing(role, side))
    lines = _lines(rig, recognised)
    _check_lengths(rig, lines)
    return Body(rig.name, recognised, _framed(rig, recognised, lines))


def _lines(rig: Object, recognised: Recognised) -> dict[Place, _Line]:
    lines = _trunk_lines(rig, recognised)
    for place in recognised.chains:
        if place[0] not in TRUNK_ROLES:
            lines[place] = _line(rig, recognised, place)
    return lines


def _line(rig: Object, recognised: Recognised, place: Place) -> _Line:
    role, side = place
    bones = [rig.data.bones[name] for name in recognised.chains[place]]
    landmarks = recognised.ends.get(place) or recognised.chains.get((NEXT_ROLE.get(role, ""), side), ())[:1]
    ends = [rig.data.bones[name].head_local for name in landmarks] or [bones[-1].tail_local]
    return _Line(
        role=role,
        side=side,
        bones=tuple(bone.name for bone in bones),
        heads=tuple(bone.head_local.copy() for bone in bones),
        start=bones[0].head_local.copy(),
        end=sum(ends, Vector()) / len(ends),
    )


def _trunk_lines(rig: Object, recognised: Recognised) -> dict[Place, _Line]:
    """Pelvis, abdomen and chest at fixed shares of the way from the hips along the spine to the neck.

    Rigs put their root bone anywhere and have any number of spine bones; hips and neck stand where anatomy has them.
    """
    chains = recognised.chains
    spine = [rig.data.bones[name] for role in TRUNK_ROLES for name in chains.get((role, ""), ())]
    if not spine:
        return {}
    hips = sum((rig.data.bones[chains["thigh", side][0]].head_local for side in SIDES), Vector()) / 2
    above = chains.get(("neck", "")) or chains.get(("head", ""))
    top = rig.data.bones[above[0]].head_local if above else spine[-1].tail_local
    joints = [hips, *(bone.head_local for bone in spine[1:]), top]
    up = (top - hips).normalized()
    way = [hips]
    for joint in joints[1:]:  # a bone that starts below the hips is no part of the way up
        if (joint - way[-1]).dot(up) > SHORTEST_SEGMENT_M:
            way.append(joint)
    cuts = [_share_of_way(way, share) for share in (0.0, *TRUNK_ENDS, 1.0)]
    lines = {}
    for role, start, end in zip(TRUNK_ROLES, cuts, cuts[1:], strict=False):
        bones = _spine_bones_between(spine, start, end, up) if role != "pelvis" else spine[:1]
        lines[role, ""] = _Line(
            role=role,
            side="",
            bones=tuple(bone.name for bone in bones),
            heads=tuple(bone.head_local.copy() for bone in bones),
            start=start,
            end=end,
        )
    return lines


def _share_of_way(way: list[Vector], share: float) -> Vector:
    left_m = share * sum((there - here).length for here, there in zip(way, way[1:], strict=False))
    for here, there in zip(way, way[1:], strict=False):
        step_m = (there - here).length
        if left_m <= step_m:
            return here.lerp(there, left_m / step_m) if step_m else here.copy()
        left_m -= step_m
    return way[-1].copy()


def _spine_bones_between(spine: list, start: Vector, end: Vector, up: Vector) -> list:
    """The spine bones that a stretch of the trunk moves with: the one that it starts in, and those that start in it."""
    heights = [bone.head_local.dot(up) for bone in spine]
    first = max((i for i, height in enumerate(heights) if height <= start.dot(up) + SHORTEST_SEGMENT_M), default=0)
    return [bone for i, bone in enumerate(spine) if i == first or start.dot(up) < heights[i] < end.dot(up)]


def _check_lengths(rig: Object, lines: dict[Place, _Line]) -> None:
    for place, line in list(lines.items()):
        if (line.end - line.start).length >= SHORTEST_SEGMENT_M:
            continue
        if line.role in OPTIONAL_ROLES:
            del lines[place]  # as good as not there
            continue
        raise SinewError(
            f"'{rig.name}': the {in_words(line.role, line.side)} ('{line.bones[0]}') has no length; "
            "move its end in the armature's Edit Mode"
        )


@dataclass(frozen=True)
class _Directions:
    """Of the whole body: where its head is, where its belly looks, where its toes point."""

    up: Vector
    belly: Vector
    forward: Vector
    on_fours: bool


def _directions(lines: Mapping[Place, _Line]) -> _Directions:
    hips = lines["thigh", "L"].start - lines["thigh", "R"].start
    ankles = [lines[role, side].end for side in SIDES for role in ("shin", "thigh") if (role, side) in lines]
    legs_up = (lines["thigh", "L"].start + lines["thigh", "R"].start) / 2 - sum(ankles, Vector()) / len(ankles)
    up = lines["pelvis", ""].axis if ("pelvis", "") in lines else legs_up.normalized()
    trunk = lines["chest", ""].end - lines["pelvis", ""].start if ("chest", "") in lines else up
    if trunk.normalized().dot(legs_up.normalized()) < ON_FOURS:
        head = trunk.normalized()
        return _Directions(up=head, belly=_square(-legs_up, head, instead=hips.cross(head)), forward=head, on_fours=True)
    feet = sum((lines["foot", side].axis for side in SIDES if ("foot", side) in lines), Vector())
    front = _square(feet, up, instead=hips.cross(up)) if feet.length > 0.1 else hips.cross(up).normalized()
    return _Directions(up=up, belly=front, forward=front, on_fours=False)


def _framed(rig: Object, recognised: Recognised, lines: Mapping[Place, _Line]) -> dict[Place, Segment]:
    body = _directions(lines)
    left = body.up.cross(body.belly)
    segments = {}
    for (role, side), line in lines.items():
        if role in CENTRAL_ROLES:
            own_front = _square(body.belly, line.axis, instead=body.up)
            outer = _square(left, line.axis, instead=body.up)
            segments[role, side] = line.framed(own_front, _square(outer, own_front, instead=body.up), body.on_fours)
            continue
        own_front = _sided_front(rig, recognised, lines, line, body)
        outer = own_front.cross(line.axis) if side == "L" else line.axis.cross(own_front)
        segments[role, side] = line.framed(own_front, outer, body.on_fours)
    return segments


def _sided_front(
    rig: Object, recognised: Recognised, lines: Mapping[Place, _Line], line: _Line, body: _Directions
) -> Vector:
    skyward = -body.belly if body.on_fours else body.up
    if line.role in ("foot", "toes"):
        return _square(skyward + body.forward, line.axis, instead=-body.forward)
    if line.role in ("hand", "fingers"):
        return _palm(rig, recognised, line) or _elbow_front(lines, line.side, line.axis, body, above=False)
    if line.role in ("upper_arm", "forearm"):
        return _elbow_front(lines, line.side, line.axis, body, above=line.role == "upper_arm")
    return _square(body.forward, line.axis, instead=skyward)


def _elbow_front(lines: Mapping[Place, _Line], side: str, axis: Vector, body: _Directions, *, above: bool) -> Vector:
    """The flexor side, told by the bend that the elbow has at rest, else the body's front."""
    if ("upper_arm", side) in lines and ("forearm", side) in lines:
        upper, lower = lines["upper_arm", side].axis, lines["forearm", side].axis
        if upper.angle(lower) >= STRAIGHT_ELBOW_RAD:
            return _square(lower if above else -upper, axis, instead=body.forward)
    return _square(body.forward, axis, instead=body.up)


def _palm(rig: Object, recognised: Recognised, line: _Line) -> Vector | None:
    """Where the palm looks, from the two edges of the hand; nothing where the rig has no fingers."""
    edges = [rig.data.bones.get(name) for name in recognised.edges.get(line.side, (None, None)) if name]
    if len(edges) < 2 or None in edges:
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
