# SPDX-License-Identifier: GPL-3.0-or-later
"""A body as anatomical segments, each with axes that are mirrored between left and right.

Everything is in armature space and in the rest pose, independent of the armature object's transform and of the current pose.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace

from mathutils import Vector

from ....errors import SinewError
from .body_parts import CENTRAL_ROLES, BodyPart, part_label
from .recognition import Recognised

BUILDS = UPRIGHT, ON_FOUR_LEGS, SWIMMING, WINGED = ("upright", "on four legs", "swimming", "winged")


@dataclass(frozen=True)
class Segment:
    """One anatomical segment: an upper arm, a shin, the pelvis.

    bones: the bones that carry it, from the body outward. bone_starts: where each bone starts, as a fraction of the length.
    start, end: of its axis, in metres of armature space. axis: unit, from start to end. front: unit; the flexor side of
    an arm (the side that the elbow bends to), the palm of a hand, the back of a foot, the side of a leg that the toes
    point to, the belly's side of all other segments. outer: unit, away from the middle of the body; up for a shoulder
    girdle. front and outer are perpendicular to the axis. build: of BUILDS, which differ in their usual
    proportions. trunk_m: the length of the trunk from the hips to the neck, in metres; 0 if there is none. proportions: the
    usual distance from the axis to the skin in front, at the sides and behind, as fractions of the length, if a preset has
    its own; else None.
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
    build: str
    trunk_m: float = 0.0
    proportions: tuple[float, float, float] | None = None

    @property
    def on_fours(self) -> bool:
        """Whether the body stands on four legs."""
        return self.build == ON_FOUR_LEGS

    @property
    def length(self) -> float:
        """Metres from start to end."""
        return (self.end - self.start).length

    def point(self, along: float) -> Vector:
        """The point at a fraction of the length: 0 is the start, 1 the end. Values outside 0..1 extend the axis."""
        return self.start.lerp(self.end, along)

    def direction(self, around_deg: float) -> Vector:
        """The unit vector perpendicular to the axis at an angle: 0 front, 90 outer, 180 back, 270 inner."""
        angle = math.radians(around_deg)
        return self.front * math.cos(angle) + self.outer * math.sin(angle)

    def along(self, point: Vector) -> float:
        """The fraction of the length at which a point projects onto the axis."""
        return (point - self.start).dot(self.axis) / self.length

    def bone_at(self, along: float) -> str:
        """The bone that carries the segment at a fraction of its length. Split bones carry one section each."""
        return [bone for bone, start in zip(self.bones, self.bone_starts, strict=True) if start <= max(along, 0.0)][-1]


@dataclass(frozen=True)
class Body:
    """The segments of one rig, and the bones that they were recognised by."""

    rig_name: str
    recognised: Recognised
    segments: Mapping[BodyPart, Segment]

    @property
    def scheme(self) -> str:
        """The kind of rig, for the user."""
        return self.recognised.label

    def has(self, role: str, side: str) -> bool:
        """Whether the rig has this body part. The side of a central role is ignored."""
        return (role, "" if role in CENTRAL_ROLES else side) in self.segments

    def has_bone(self, role: str, side: str) -> bool:
        """Whether a bone of the rig is this part. A shoulder blade can be a segment of the chest's bones."""
        return (role, "" if role in CENTRAL_ROLES else side) in self.recognised.chains

    def segment(self, role: str, side: str) -> Segment:
        """The segment of a role, for one side. Of a central role, side "R" gets the mirror image of what "L" gets.

        Raises SinewError if the rig lacks the segment. The message names the part, the kind of rig and the remedy.
        """
        if not self.has(role, side):
            raise self.missing(role, "" if role in CENTRAL_ROLES else side)
        if role not in CENTRAL_ROLES:
            return self.segments[role, side]
        central = self.segments[role, ""]
        return replace(central, outer=-central.outer) if side == "R" else central

    def with_proportions(self, proportions: Mapping[str, tuple[float, float, float]]) -> "Body":
        """This body with other usual distances to the skin. proportions: as in `Segment`, by role."""
        segments = {part: replace(segment, proportions=proportions.get(part[0])) for part, segment in self.segments.items()}
        return replace(self, segments=segments)

    def missing(self, role: str, side: str) -> SinewError:
        """The error for a body part that the rig lacks."""
        expected = self.recognised.expected.get((role, side))
        why = f"there is no bone '{expected}'" if expected else "no bone was recognised as it"
        return SinewError(
            f"'{self.rig_name}' looks like {self.scheme}, but its {part_label(role, side)} is missing: {why}. "
            "Name the bone in the table Bones of this operator, or add muscles by hand with Add Tissue"
        )
