# SPDX-License-Identifier: GPL-3.0-or-later
"""Positions relative to a bone, in lengths of the bone, so that they can be transferred to another character.

The axes are those of the bone or, on a recognised rig, those of the body segment that the bone belongs to (an upper arm, a
shin). Segments have the same axes on every kind of rig, whatever the names and rolls of its bones.
"""

import math
from dataclasses import dataclass

import numpy as np
from mathutils import Vector

from ..errors import SinewError
from ..scene import bone_geometry
from .placing.recognise import segments

# Cosine of the angle between z and the x axis above which the z axis is the reference for a twist instead.
LARGEST_REFERENCE_COSINE = 0.8


@dataclass(frozen=True)
class BoneAxes:
    """The axes of a bone or segment at rest, armature space.

    axes: (3, 3) float64, columns; y along the bone. start: (3,) float64, the origin, m. length: m, the unit of length.
    """

    axes: np.ndarray
    start: np.ndarray
    length: float

    def to_local(self, point: Vector) -> np.ndarray:
        """(3,) float64: a point of armature space in these axes, in lengths of the bone."""
        return np.linalg.solve(self.axes, np.array(point, float) - self.start) / self.length

    def to_armature(self, local) -> Vector:
        """A point of armature space, m, from its three coordinates in these axes."""
        return Vector(self.start + self.axes @ np.array(local, float) * self.length)

    def twist_deg(self, x: Vector, z: Vector) -> float:
        """The angle of a tissue's x axis about its z axis, from a reference direction of these axes. Armature space."""
        x, z = self._local_direction(x), self._local_direction(z)
        reference, aside = _references(z)
        return math.degrees(math.atan2(x @ aside, x @ reference))

    def twisted(self, twist_deg: float, z: Vector) -> Vector:
        """The x axis of a tissue with this z axis and twist: the inverse of `twist_deg`."""
        reference, aside = _references(self._local_direction(z))
        angle = math.radians(twist_deg)
        return Vector(self.axes @ (reference * math.cos(angle) + aside * math.sin(angle)))

    def _local_direction(self, direction: Vector) -> np.ndarray:
        local = np.linalg.solve(self.axes, np.array(direction, float))
        return local / np.linalg.norm(local)


def _references(z: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Two unit vectors perpendicular to z and to each other. They jump only where z passes a fixed angle to the x axis."""
    axis = np.array((1.0, 0.0, 0.0) if abs(z[0]) < LARGEST_REFERENCE_COSINE else (0.0, 0.0, 1.0))
    reference = axis - z * (axis @ z)
    reference /= np.linalg.norm(reference)
    return reference, np.cross(z, reference)


def axes_of_bone(rig, name: str) -> BoneAxes:
    """The axes of a bone, from its head."""
    axes = np.array(bone_geometry.rest_tail(rig, name).to_3x3(), float)
    start = np.array(bone_geometry.point_along(rig, name, 0.0), float)
    return BoneAxes(axes, start, bone_geometry.bone_length(rig, name))


class RigSegments:
    """The body segments of a rig by role ("upper_arm.L", "head"). Empty for a rig that Sinew does not recognise.

    scheme: the kind of rig, or "".
    """

    def __init__(self, rig):
        try:
            body = segments.recognise(rig)
        except SinewError:
            body = None  # not an error here: on an unknown rig, positions are relative to bones alone
        self.scheme = body.scheme if body else ""
        by_part = body.segments if body else {}
        self._segments = {f"{role}.{side}".rstrip("."): segment for (role, side), segment in by_part.items()}
        self._role_of_bone = {bone: role for role, segment in self._segments.items() for bone in segment.bones}

    def role_of(self, bone: str) -> str:
        """The role of the segment that a bone belongs to, or ""."""
        return self._role_of_bone.get(bone, "")

    def bones_of(self, role: str) -> tuple[str, ...]:
        """The bones of a role's segment. Empty if this rig has no such segment."""
        segment = self._segments.get(role)
        return tuple(segment.bones) if segment else ()

    def axes_of(self, role: str) -> BoneAxes | None:
        """The axes of a role's segment. None if this rig has no such segment."""
        segment = self._segments.get(role)
        if segment is None:
            return None
        axes = np.array((segment.outer, segment.axis, segment.front), float).T
        return BoneAxes(axes, np.array(segment.start, float), segment.length)

    def bone_at(self, role: str, along: float) -> str:
        """The bone that carries a role's segment at a fraction of its length. KeyError if this rig has no such segment."""
        return self._segments[role].bone_at(along)
