# SPDX-License-Identifier: GPL-3.0-or-later
"""`sinew.mesh_to_tissues` makes rigid tissues of a mesh, such as a scanned bone."""

import numpy as np
from bpy.props import IntProperty, StringProperty
from bpy.types import Operator
from mathutils import Vector

from ..errors import SinewError
from ..muscles import edit
from ..muscles.placing.fit import mesh_parts
from ..muscles.placing.fit.skin_surface import SkinSurface
from ..scene import bone_geometry, rest_body
from ..scene.linked_data import writable
from .base import SinewOperator, rig_of_context


class SINEW_OT_mesh_to_tissues(SinewOperator, Operator):
    """Make rigid tissues of the other selected meshes, such as scanned bones: each becomes ellipsoids on a bone"""

    bl_idname, bl_label = "sinew.mesh_to_tissues", "Mesh to Tissues"

    bone: StringProperty(name="Bone", description="The bone that carries the tissues. Empty: the nearest one")
    count: IntProperty(name="Ellipsoids", description="Most ellipsoids for each mesh", default=6, min=1, max=64)

    def run(self, context):
        rig = writable(rig_of_context(context))
        meshes = [found for found in context.selected_objects if found.type == "MESH" and found != context.object]
        if not meshes:
            raise SinewError(f"Select the meshes, then Shift-click {rig.name}, so that it is active")
        if self.bone and not bone_geometry.has_bone(rig, self.bone):
            raise SinewError(f"{rig.name} has no bone '{self.bone}'")
        shapes = []
        for mesh in meshes:
            surface = SkinSurface.of(mesh, rig)
            to_rig = rig.matrix_world.inverted() @ mesh.matrix_world
            points = rest_body.read_points(mesh).astype(float) @ _linear(to_rig).T + to_rig.translation
            bone = self.bone or _nearest_bone(rig, Vector(points.mean(0)))
            shapes += mesh_parts.ellipsoids(surface, points, self.count, mesh.name, bone)
        edit.add(rig, shapes)
        return f"{len(shapes)} tissues made of {', '.join(mesh.name for mesh in meshes)}"


def _linear(matrix) -> np.ndarray:
    return np.array(matrix.to_3x3())


def _nearest_bone(rig, point: Vector) -> str:
    """The bone whose middle is nearest to a point of armature space."""
    return min(rig.data.bones, key=lambda bone: ((bone.head_local + bone.tail_local) / 2 - point).length).name
