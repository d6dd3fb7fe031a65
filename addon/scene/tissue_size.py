# SPDX-License-Identifier: GPL-3.0-or-later
"""Semi-axes, width ratio and offset of a tissue, computed from the transforms of its Empty and written back to them."""

import math

from mathutils import Vector

from . import bone_geometry, tissue_empty

SMALLEST_M = 1e-5


def semi_axes(settings) -> tuple[float, float, float]:
    """The half widths along x and y and the half length along z, in metres."""
    unit = _unit(settings.id_data)
    return tuple(abs(scale) * length for scale, length in zip(settings.id_data.scale, unit))


def set_semi_axes(settings, values):
    """Sets the semi-axes in metres. Mirrored axes stay mirrored."""
    empty = settings.id_data
    signed = (math.copysign(max(value, SMALLEST_M), scale) for value, scale in zip(values, empty.scale))
    empty.scale = [value / length for value, length in zip(signed, _unit(empty))]


def width_ratio(settings) -> float:
    """The width along x divided by the width along y."""
    x, y, _z = semi_axes(settings)
    return x / max(y, SMALLEST_M)


def set_width_ratio(settings, ratio: float):
    """Sets the ratio of the widths and keeps their product, so that the volume stays."""
    x, y, z = semi_axes(settings)
    mean = math.sqrt(x * y)
    set_semi_axes(settings, (mean * math.sqrt(ratio), mean / math.sqrt(ratio), z))


def offset(settings) -> float:
    """The distance from the centre to the line of the origin bone in the rest pose, in metres."""
    from_line = _from_line(settings.id_data)
    return from_line.length if from_line is not None else 0.0


def set_offset(settings, distance: float):
    """Moves the centre to this distance, in metres, from the line of the origin bone."""
    empty = settings.id_data
    from_line = _from_line(empty)
    if from_line is None:
        return  # the panel says that the bone is missing
    if from_line.length > SMALLEST_M:
        outward = from_line.normalized()
    else:
        outward = bone_geometry.rest_axis(empty.parent, empty.parent_bone, 2)
    to_parent = tissue_empty.rest_parent(empty, empty.parent).to_3x3().inverted()
    empty.location = empty.location + to_parent @ (outward * distance - from_line)


def _from_line(empty) -> Vector | None:
    """The vector from the line of the origin bone to the center, perpendicular to the line, in armature space.

    None if the rig has no such bone.
    """
    if empty.parent is None or not bone_geometry.has_bone(empty.parent, empty.parent_bone):
        return None
    rig, bone = empty.parent, empty.parent_bone
    centre = tissue_empty.rest_parent(empty, rig) @ empty.location
    along, start = bone_geometry.rest_axis(rig, bone, 1), bone_geometry.point_along(rig, bone, 0.0)
    return (centre - start) - along * (centre - start).dot(along)


def _unit(empty) -> Vector:
    """The length in metres, along each axis, of a scale of 1."""
    return empty.matrix_parent_inverse.to_scale() * empty.empty_display_size
