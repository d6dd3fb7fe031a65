# SPDX-License-Identifier: GPL-3.0-or-later
"""Changes a muscle by its handles: origin, insertion, via points and widths. All points are in armature space, at rest."""

from dataclasses import replace

from mathutils import Matrix, Vector

from ..errors import SinewError
from ..scene import bone_geometry
from ..scene.tissue_empty import TissueShape

SHORTEST_M = 1e-4
NARROWEST_M = 1e-4
FARTHEST_M = 1e6
ORIGIN, INSERTION, WIDTH_X, WIDTH_Y = "ORIGIN", "INSERTION", "WIDTH_X", "WIDTH_Y"


def with_ends(shape: TissueShape, origin: Vector, insertion: Vector) -> TissueShape:
    """The muscle between two other points. Belly and tendons keep their fractions of the length, the belly its widths.

    Raises SinewError if the points are the same.
    """
    line = insertion - origin
    if line.length < SHORTEST_M:
        raise SinewError(f"{shape.name} would have no length. Move its origin and its insertion apart")
    factor = line.length / (shape.insertion - shape.origin).length
    direction = line.normalized()
    rotation = (shape.rotation @ Vector((0, 0, 1))).rotation_difference(direction) @ shape.rotation
    half_length, origin_tendon = factor * shape.semi_axes.z, factor * shape.origin_tendon
    return replace(
        shape,
        centre=origin + direction * (origin_tendon + half_length),
        rotation=rotation,
        semi_axes=Vector((shape.semi_axes.x, shape.semi_axes.y, half_length)),
        origin_tendon=origin_tendon,
        insertion_tendon=factor * shape.insertion_tendon,
    )


def with_via_point(shape: TissueShape, index: int, point: Vector) -> TissueShape:
    """The muscle with another position of one via point."""
    via_points = list(shape.via_points)
    via_points[index] = (via_points[index][0], point)
    return replace(shape, via_points=tuple(via_points))


def with_width(shape: TissueShape, axis: int, point: Vector) -> TissueShape:
    """The muscle whose belly reaches to a point across its long axis. axis: 0 for local x, 1 for y."""
    across = shape.rotation @ Vector((axis == 0, axis == 1, 0.0))
    semi_axes = shape.semi_axes.copy()
    semi_axes[axis] = max(abs((point - shape.centre).dot(across)), NARROWEST_M)
    return replace(shape, semi_axes=semi_axes)


def with_belly_at(shape: TissueShape, fraction: float) -> TissueShape:
    """The muscle whose belly is at a fraction of the free length between its ends. 0: at the origin, 1: at the insertion."""
    free = shape.origin_tendon + shape.insertion_tendon
    origin_tendon = min(max(fraction, 0.0), 1.0) * free
    direction = shape.rotation @ Vector((0, 0, 1))
    return replace(
        shape,
        centre=shape.origin + direction * (origin_tendon + shape.semi_axes.z),
        origin_tendon=origin_tendon,
        insertion_tendon=free - origin_tendon,
    )


def handles_of(shape: TissueShape) -> dict[str, Vector]:
    """The points of all handles by name, at rest. Via points are VIA 0, VIA 1, and so on."""
    x, y = (shape.rotation @ Vector((axis == 0, axis == 1, 0.0)) * shape.semi_axes[axis] for axis in (0, 1))
    vias = {f"VIA {index}": point for index, (_bone, point) in enumerate(shape.via_points)}
    return {
        ORIGIN: shape.origin,
        INSERTION: shape.insertion,
        WIDTH_X: shape.centre + x,
        WIDTH_Y: shape.centre + y,
        **vias,
    }


def bone_of_handle(shape: TissueShape, handle: str) -> str:
    """The bone that moves a handle."""
    if handle.startswith("VIA "):
        return shape.via_points[int(handle[4:])][0]
    return shape.insertion_bone if handle == INSERTION else shape.origin_bone


def moved(shape: TissueShape, handle: str, point: Vector) -> TissueShape:
    """The muscle with one handle at a point at rest. Raises SinewError if it has no such handle, or would have no length."""
    if handle not in handles_of(shape):
        raise SinewError(f"{shape.name} has no handle '{handle}'")
    if not all(abs(coordinate) < FARTHEST_M for coordinate in point):  # also false for a coordinate that is not a number
        raise SinewError(f"{shape.name}: the new position is farther than {FARTHEST_M:g} m. Choose one near the armature")
    if handle == ORIGIN:
        return with_ends(shape, point, shape.insertion)
    if handle == INSERTION:
        return with_ends(shape, shape.origin, point)
    if handle in (WIDTH_X, WIDTH_Y):
        return with_width(shape, (WIDTH_X, WIDTH_Y).index(handle), point)
    return with_via_point(shape, int(handle[4:]), point)


def on_bone(rig, bone: str, point: Vector, distance_m: float) -> Vector:
    """The point nearest to `point` that has a distance from the line of a bone: a surface around the bone, at rest."""
    head, tail = (bone_geometry.point_along(rig, bone, fraction) for fraction in (0.0, 1.0))
    along = tail - head
    fraction = min(max((point - head).dot(along) / along.length_squared, 0.0), 1.0)
    nearest = head + fraction * along
    aside = point - nearest
    if aside.length < SHORTEST_M:
        aside = bone_geometry.rest_axis(rig, bone, 2)
    return nearest + distance_m * aside.normalized()


def distance_to_bone(rig, bone: str, point: Vector) -> float:
    """The distance of a point at rest from the line of a bone."""
    return (point - on_bone(rig, bone, point, 0.0)).length


def to_pose(rig, bone: str) -> Matrix:
    """The matrix that moves points at rest with a bone to its pose, in armature space."""
    return rig.pose.bones[bone].matrix @ rig.data.bones[bone].matrix_local.inverted()
