# SPDX-License-Identifier: GPL-3.0-or-later
"""What a ray meets on the skins of a rig in the current pose, and the bone that moves the skin there."""

from dataclasses import dataclass

from mathutils import Vector

from . import characters


@dataclass(frozen=True)
class SurfaceHit:
    """point: on the posed skin, in world space. bone: the deform bone with the largest weight there, or an empty text."""

    point: Vector
    bone: str
    distance: float


def first_hit(context, rig, start: Vector, along: Vector) -> SurfaceHit | None:
    """The first point on a ray in world space of the meshes that follow a rig, or None. along: of any length."""
    depsgraph = context.evaluated_depsgraph_get()
    nearest = None
    for skin in characters.skins_of(rig):
        evaluated = skin.evaluated_get(depsgraph)
        if not evaluated.is_evaluated or not len(evaluated.data.polygons):
            continue
        to_mesh = evaluated.matrix_world.inverted_safe()
        is_hit, point, _normal, face = evaluated.ray_cast(to_mesh @ start, (to_mesh.to_3x3() @ along).normalized())
        if not is_hit:
            continue
        point = evaluated.matrix_world @ point
        distance = (point - start).length
        if nearest is None or distance < nearest.distance:
            nearest = SurfaceHit(point, _bone_of_face(rig, skin, evaluated.data, face), distance)
    return nearest


def _bone_of_face(rig, skin, mesh, face: int) -> str:
    weights: dict[str, float] = {}
    for vertex in mesh.polygons[face].vertices:
        for group in mesh.vertices[vertex].groups:
            if group.group < len(skin.vertex_groups):
                name = skin.vertex_groups[group.group].name
                bone = rig.data.bones.get(name)
                if bone is not None and bone.use_deform:
                    weights[name] = weights.get(name, 0.0) + group.weight
    return max(weights, key=weights.__getitem__, default="")
