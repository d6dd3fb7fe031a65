# SPDX-License-Identifier: GPL-3.0-or-later
"""Places told from bones, not in metres: along, across and around a bone, in its own length, so that they travel.

A frame is a bone's own, or that of the body's segment that it belongs to (an upper arm, a shin), where the rig is
recognised: segments look the same on every kind of rig, whatever it calls its bones and however it rolls them.
"""

import math
from dataclasses import dataclass

import numpy as np
from mathutils import Vector

from ..errors import SinewError
from ..scene import bone_geometry
from .placing.recognise import segments

REFERENCE_IS_TOO_NEAR = 0.8


@dataclass(frozen=True)
class Frame:
    """Axes (columns; y along the bone), the point where they begin, and the length that is 1 in them."""

    axes: np.ndarray
    start: np.ndarray
    length: float

    def to_frame(self, point: Vector) -> np.ndarray:
        return np.linalg.solve(self.axes, np.array(point, float) - self.start) / self.length

    def from_frame(self, place) -> Vector:
        return Vector(self.start + self.axes @ np.array(place, float) * self.length)

    def twist_deg(self, x: Vector, z: Vector) -> float:
        """How far a tissue's x axis is turned about its z axis, from where the frame's own axes have it."""
        x, z = self._direction(x), self._direction(z)
        reference, aside = _references(z)
        return math.degrees(math.atan2(x @ aside, x @ reference))

    def twisted(self, twist_deg: float, z: Vector) -> Vector:
        """The x axis of that twist."""
        reference, aside = _references(self._direction(z))
        angle = math.radians(twist_deg)
        return Vector(self.axes @ (reference * math.cos(angle) + aside * math.sin(angle)))

    def _direction(self, wanted: Vector) -> np.ndarray:
        own = np.linalg.solve(self.axes, np.array(wanted, float))
        return own / np.linalg.norm(own)


def _references(z: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Two directions square to z and to each other, which only jump where z passes a fixed angle to the x axis."""
    near = np.array((1.0, 0.0, 0.0) if abs(z[0]) < REFERENCE_IS_TOO_NEAR else (0.0, 0.0, 1.0))
    reference = near - z * (near @ z)
    reference /= np.linalg.norm(reference)
    return reference, np.cross(z, reference)


def of_bone(rig, name: str) -> Frame:
    """The frame of a bone, from its head."""
    axes = np.array(bone_geometry.rest_tail(rig, name).to_3x3(), float)
    start = np.array(bone_geometry.point_along(rig, name, 0.0), float)
    return Frame(axes, start, bone_geometry.bone_length(rig, name))


class Roles:
    """The body's segments of a rig by role ("upper_arm.L"), as far as Sinew recognises them."""

    def __init__(self, rig):
        try:
            body = segments.recognise(rig)
        except SinewError:
            body = None  # most rigs are no human; their bones have names all the same
        self.scheme = body.scheme if body else ""
        found = body.segments if body else {}
        self._segments = {f"{role}.{side}".rstrip("."): segment for (role, side), segment in found.items()}
        self._role_of_bone = {bone: role for role, segment in self._segments.items() for bone in segment.bones}

    def role_of(self, bone: str) -> str:
        """The role of the segment that a bone belongs to, or an empty text."""
        return self._role_of_bone.get(bone, "")

    def bones_of(self, role: str) -> tuple[str, ...]:
        """The bones of a role's segment; none where this rig has no such segment."""
        found = self._segments.get(role)
        return tuple(found.bones) if found else ()

    def frame(self, role: str) -> Frame | None:
        """The frame of a role's segment; None where this rig has none."""
        found = self._segments.get(role)
        if found is None:
            return None
        return Frame(np.array((found.outer, found.axis, found.front), float).T, np.array(found.start, float), found.length)

    def bone_at(self, role: str, along: float) -> str:
        """The bone that carries a role's segment at a fraction of its length."""
        return self._segments[role].bone_at(along)
