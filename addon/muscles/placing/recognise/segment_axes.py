# SPDX-License-Identifier: GPL-3.0-or-later
"""Front and outer axes of the segments of a body, from its rest pose: elbows, palms, feet, spine."""

import math
from collections.abc import Mapping
from dataclasses import dataclass

from bpy.types import Object
from mathutils import Vector

from ...axes import perpendicular
from .body import ON_FOUR_LEGS, SWIMMING, UPRIGHT, WINGED, Segment
from .body_parts import CENTRAL_ROLES, SIDE_DEFINING_ROLES, SIDES, BodyPart
from .kind import BIRD
from .recognition import Recognised
from .segment_lines import SHORTEST_SEGMENT_M, SegmentLine

STRAIGHT_ELBOW_RAD = math.radians(5)
# 6 degrees: a direction of the body this close to a segment's axis is an accident of the pose and does not define a front.
NEARLY_PARALLEL_SINE = 0.1
WING = ("upper_arm", "forearm", "hand", "fingers")
SAME_START = 0.02  # fraction of the length; a twist bone that starts where its segment starts carries no section
# Cosine between the trunk and the direction from the feet to the hips, below which a body stands on four legs.
ON_FOURS = 0.5


@dataclass(frozen=True)
class Directions:
    """Unit vectors of the whole body: towards its head, out of its belly, where its toes point."""

    up: Vector
    belly: Vector
    forward: Vector
    on_fours: bool

    @property
    def left(self) -> Vector:
        """Unit, to the left of the body."""
        return self.up.cross(self.belly).normalized()


def segments_of(
    rig: Object, recognised: Recognised, lines: Mapping[BodyPart, SegmentLine], kind: str = ""
) -> dict[BodyPart, Segment]:
    """The segments along these lines. kind: of `kind.KINDS`; a bird's wings bend forward."""
    body = directions_of(lines, recognised.left)
    standing = ON_FOUR_LEGS if body.on_fours else UPRIGHT
    build = SWIMMING if recognised.lines else WINGED if kind == BIRD else standing
    left = body.left
    trunk_m = _trunk_m(lines)
    segments = {}
    for (role, side), line in lines.items():
        if role in CENTRAL_ROLES:
            front = _across(body.belly, line.axis, instead=body.up)
            outer = _across(_across(left, line.axis, instead=body.up), front, instead=body.up)
        else:
            if kind == BIRD and line.role in WING:
                front = _across(body.forward, line.axis, instead=body.up)
            else:
                front = _sided_front(rig, recognised, lines, line, body)
            outer = front.cross(line.axis) if side == "L" else line.axis.cross(front)
        segments[role, side] = _segment(line, front, outer, build, trunk_m)
    return segments


def _trunk_m(lines: Mapping[BodyPart, SegmentLine]) -> float:
    """The length of the trunk from the hips to the neck, m; 0 for a body without chest or pelvis."""
    if ("pelvis", "") not in lines or ("chest", "") not in lines:
        return 0.0
    return (lines["chest", ""].end - lines["pelvis", ""].start).length


def _segment(line: SegmentLine, front: Vector, outer: Vector, build: str, trunk_m: float) -> Segment:
    length = (line.end - line.start).length
    starts = [(head - line.start).dot(line.axis) / length for head in line.heads[1:]]
    carriers = [(0.0, line.bones[0])]
    carriers += sorted((start, bone) for start, bone in zip(starts, line.bones[1:], strict=True) if SAME_START < start < 1.0)
    return Segment(
        role=line.role,
        side=line.side,
        bones=tuple(bone for _, bone in carriers),
        bone_starts=tuple(start for start, _ in carriers),
        start=line.start,
        end=line.end,
        axis=line.axis,
        front=front,
        outer=outer,
        build=build,
        trunk_m=trunk_m,
    )


def directions_of(lines: Mapping[BodyPart, SegmentLine], to_left: Vector | None = None) -> Directions:
    """The directions of a body that has a pair of limbs, or whose left is `to_left` (unit)."""
    pairs = (role for role in SIDE_DEFINING_ROLES if all((role, side) in lines for side in SIDES))
    pair = next(pairs, None)
    if pair is None:
        hips = to_left
    else:
        left, right = lines[pair, "L"], lines[pair, "R"]
        hips = left.start - right.start
        if hips.length < SHORTEST_SEGMENT_M:  # fins can start in the middle of the body
            hips = left.end - right.end
    if pair == "thigh":
        ankles = [lines[role, side].end for side in SIDES for role in ("shin", "thigh") if (role, side) in lines]
        legs_up = (lines["thigh", "L"].start + lines["thigh", "R"].start) / 2 - sum(ankles, Vector()) / len(ankles)
    else:  # without legs a body is upright
        legs_up = _trunk_direction(lines)
    up = lines["pelvis", ""].axis if ("pelvis", "") in lines else legs_up.normalized()
    lowest = lines.get(("pelvis", "")) or lines.get(("chest", ""))  # the pelvis can have no length
    trunk = lines["chest", ""].end - lowest.start if ("chest", "") in lines else up
    if trunk.normalized().dot(legs_up.normalized()) < ON_FOURS:
        head = trunk.normalized()
        return Directions(up=head, belly=_across(-legs_up, head, instead=hips.cross(head)), forward=head, on_fours=True)
    feet = sum((lines["foot", side].axis for side in SIDES if ("foot", side) in lines), Vector())
    front = _across(feet, up, instead=hips.cross(up)) if feet.length > 0.1 else hips.cross(up).normalized()
    return Directions(up=up, belly=front, forward=front, on_fours=False)


def _trunk_direction(lines: Mapping[BodyPart, SegmentLine]) -> Vector:
    """The unit vector along the trunk or the neck; the armature's Z for a body without them."""
    return next(
        (lines[role, ""].axis for role in ("chest", "pelvis", "neck", "head") if (role, "") in lines), Vector((0, 0, 1))
    )


def _sided_front(
    rig: Object, recognised: Recognised, lines: Mapping[BodyPart, SegmentLine], line: SegmentLine, body: Directions
) -> Vector:
    skyward = -body.belly if body.on_fours else body.up
    if line.role in ("foot", "toes"):
        return _across(skyward + body.forward, line.axis, instead=-body.forward)
    if line.role in ("hand", "fingers"):
        palm = _palm(rig, recognised, line)
        if palm is None and body.on_fours:  # the sole of a paw or hoof
            palm = _across(-skyward - body.forward, line.axis, instead=-body.forward)
        return palm or _elbow_front(lines, line.side, line.axis, body, above=False)
    if line.role in ("upper_arm", "forearm"):
        return _elbow_front(lines, line.side, line.axis, body, above=line.role == "upper_arm")
    return _across(body.forward, line.axis, instead=skyward)


def _elbow_front(lines: Mapping[BodyPart, SegmentLine], side: str, axis: Vector, body: Directions, *, above: bool) -> Vector:
    """The flexor side, from the rest bend of the elbow; the body's front where the elbow is straight at rest."""
    if ("upper_arm", side) in lines and ("forearm", side) in lines:
        upper, lower = lines["upper_arm", side].axis, lines["forearm", side].axis
        if upper.angle(lower) >= STRAIGHT_ELBOW_RAD:
            return _across(lower if above else -upper, axis, instead=body.forward)
    return _across(body.forward, axis, instead=body.up)


def _palm(rig: Object, recognised: Recognised, line: SegmentLine) -> Vector | None:
    """The normal of the palm, from the two edges of the hand. None if the rig has no fingers."""
    edges = [rig.data.bones.get(name) for name in recognised.edges.get(line.side, (None, None)) if name]
    if len(edges) < 2 or None in edges:
        return None
    across = edges[1].head_local - edges[0].head_local
    palm = across.cross(line.axis) if line.side == "L" else line.axis.cross(across)
    return palm.normalized() if palm.length > SHORTEST_SEGMENT_M else None


def _across(direction: Vector, axis: Vector, *, instead: Vector) -> Vector:
    """The unit part of a direction perpendicular to an axis. `instead` replaces a direction nearly parallel to it."""
    return perpendicular(axis, direction, instead, parallel_sine=NEARLY_PARALLEL_SINE)
