# SPDX-License-Identifier: GPL-3.0-or-later
"""Axes from one exact direction and others that are only approximate: a tissue's rotation, the front of a segment."""

from mathutils import Matrix, Vector

# Sine of the angle to the axis below which a direction counts as parallel. Blender's vectors and bone axes are float32,
# exact to about 1e-6 after a few operations: at this limit the result is still exact to 0.06 degrees, far below it is
# noise.
PARALLEL_SINE = 1e-3


def perpendicular(axis: Vector, *directions: Vector, parallel_sine: float = PARALLEL_SINE) -> Vector:
    """The unit vector perpendicular to `axis` (unit) that is closest to the first direction that is not parallel to it.

    Where all directions are parallel to the axis or zero, the result is any perpendicular vector.
    """
    for direction in directions:
        part = direction - axis * direction.dot(axis)
        if part.length > parallel_sine * direction.length:
            return part.normalized()
    return axis.orthogonal().normalized()


def axes_along(z: Vector, x_like: Vector) -> Matrix:
    """(3, 3) right-handed axes as columns, with this z axis (unit) and the x axis as close to `x_like` as possible."""
    x = perpendicular(z, x_like)
    return Matrix((x, z.cross(x), z)).transposed()
