# SPDX-License-Identifier: GPL-3.0-or-later
"""Muscle paths in the rest pose, and adding via points to them (docs/mathematics/paths.md)."""

import _sinew
import numpy as np
from mathutils import Vector

from ..errors import SinewError
from ..scene import bone_geometry, characters, tissue_empty

_AT_REST = np.eye(4, dtype=np.float32)[None]


def muscle_of(active):
    """The muscle of an object that is a muscle's Empty or one of its via points. Raises SinewError for other objects."""
    if active is not None and tissue_empty.is_via(active) and active.sinew.tissue.muscle:
        if not tissue_empty.is_used(active.sinew.tissue.muscle):
            raise SinewError(
                f"{active.name}: its muscle {active.sinew.tissue.muscle.name} was deleted: delete the via point, too"
            )
        return active.sinew.tissue.muscle
    if active is None or not tissue_empty.is_tissue(active) or active.sinew.tissue.kind != "MUSCLE":
        raise SinewError("Select a muscle or one of its via points")
    if active.parent is None or active.parent.type != "ARMATURE":
        raise SinewError(f"{active.name} has no armature: parent it to a bone")
    return active


def rest_path(shape: tissue_empty.TissueShape, spheres: list[tissue_empty.TissueShape]) -> list[Vector]:
    """Points along a muscle's path in the rest pose, from origin to insertion, armature space.

    spheres: must include those that the muscle wraps around. Raises ValueError from the core if there is no such path.
    """
    # In the rest pose no bone has moved, so one bone at the armature's origin represents all bones.
    skeleton = _sinew.Skeleton(["rest"], np.array([-1], np.int32), _AT_REST)
    tissues = [_at_rest(shape), *(_at_rest(sphere) for sphere in spheres if sphere.name in shape.wraps)]
    points, offsets = _sinew.Musculature(skeleton, tissues).path_points(_AT_REST)
    return [Vector(point) for point in points[: offsets[1]].tolist()]


def _at_rest(shape: tissue_empty.TissueShape) -> _sinew.Tissue:
    """The core's tissue for a shape whose bones are all bone 0."""
    return _sinew.Tissue(
        shape.name,
        shape.kind,
        0,
        0,
        tuple(shape.centre),
        tuple(shape.rotation),
        tuple(shape.semi_axes),
        shape.origin_tendon,
        shape.insertion_tendon,
        via_points=[(0, tuple(point)) for _bone, point in shape.via_points],
        wraps=shape.wraps,
    )


def path_of(muscle) -> list[Vector]:
    """Points along the path of a muscle's Empty in the rest pose, armature space. Raises SinewError if there is no path."""
    rig = muscle.parent
    shape = tissue_empty.read(muscle, rig)
    spheres = [tissue_empty.read(empty, rig) for empty in characters.tissues_of(rig) if empty.name in shape.wraps]
    try:
        return rest_path(shape, spheres)
    except ValueError as error:
        raise SinewError(str(error)) from error


def add_via_point(muscle, share: float, bone: str = ""):
    """Puts a via point on a muscle's path, at a share of its length; returns its Empty.

    bone: what carries it; empty takes the nearest of the bones from origin to insertion. Raises SinewError.
    """
    rig = muscle.parent
    shape, path = tissue_empty.read(muscle, rig), _sinew.Path(np.array(path_of(muscle), np.float64))
    at = share * path.length
    point = Vector(path.at(at))
    carrier = bone or _nearest_bone(rig, shape, point)
    if not bone_geometry.has_bone(rig, carrier):
        raise SinewError(f"{rig.name} has no bone '{carrier}'")
    place = sum(path.nearest_length(own) < at for _bone, own in shape.via_points)
    for order, via in enumerate(tissue_empty.vias_of(muscle)):
        via.sinew.tissue.order = order + (order >= place)
    via = tissue_empty.add_via(muscle, carrier, point, place)
    characters.forget()
    return via


def _nearest_bone(rig, shape: tissue_empty.TissueShape, point: Vector) -> str:
    def distance(bone: str) -> float:
        ends = (bone_geometry.point_along(rig, bone, share) for share in (0.0, 1.0))
        nearest, _share = _sinew.nearest_on_segment(point, *ends)
        return (Vector(nearest) - point).length

    return min(bone_geometry.bones_between(rig, shape.origin_bone, shape.insertion_bone), key=distance)
