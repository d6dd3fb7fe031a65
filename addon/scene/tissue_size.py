# SPDX-License-Identifier: GPL-3.0-or-later
"""A tissue's sizes and place as a person thinks of them, read from and written to its Empty: nothing is stored twice."""

import math

from mathutils import Vector

from . import bone_geometry, tissue_empty

SMALLEST_M = 1e-5


def semi_axes(settings) -> tuple[float, float, float]:
    """Half widths and half length, metres."""
    unit = _unit(settings.id_data)
    return tuple(abs(scale) * length for scale, length in zip(settings.id_data.scale, unit))


def set_semi_axes(settings, values):
    empty = settings.id_data
    signed = (math.copysign(max(value, SMALLEST_M), scale) for value, scale in zip(values, empty.scale))
    empty.scale = [value / length for value, length in zip(signed, _unit(empty))]


def width_ratio(settings) -> float:
    """The width along x over that along y."""
    x, y, _z = semi_axes(settings)
    return x / max(y, SMALLEST_M)


def set_width_ratio(settings, ratio: float):
    x, y, z = semi_axes(settings)
    mean = math.sqrt(x * y)
    set_semi_axes(settings, (mean * math.sqrt(ratio), mean / math.sqrt(ratio), z))


def offset(settings) -> float:
    """Distance of the centre from the line of the origin bone in the rest pose, metres."""
    aside = _aside(settings.id_data)
    return aside.length if aside is not None else 0.0


def set_offset(settings, distance: float):
    empty = settings.id_data
    aside = _aside(empty)
    if aside is None:
        return  # without a bone there is no line, and the panel says so
    outward = (
        aside.normalized() if aside.length > SMALLEST_M else bone_geometry.rest_axis(empty.parent, empty.parent_bone, 2)
    )
    to_parent = tissue_empty.rest_parent(empty, empty.parent).to_3x3().inverted()
    empty.location = empty.location + to_parent @ (outward * distance - aside)


def _aside(empty) -> Vector | None:
    """From the origin bone's line to the centre, square to the bone; armature space."""
    if empty.parent is None or not bone_geometry.has_bone(empty.parent, empty.parent_bone):
        return None
    rig, bone = empty.parent, empty.parent_bone
    centre = tissue_empty.rest_parent(empty, rig) @ empty.location
    along, start = bone_geometry.rest_axis(rig, bone, 1), bone_geometry.point_along(rig, bone, 0.0)
    return (centre - start) - along * (centre - start).dot(along)


def _unit(empty) -> Vector:
    """Metres that a scale of 1 is, along each axis."""
    return empty.matrix_parent_inverse.to_scale() * empty.empty_display_size
