# SPDX-License-Identifier: GPL-3.0-or-later
"""The deformers that are compared: Sinew, and Blender's deformers on temporary objects that share the mesh.

The temporary objects show the rest body (`rest_body`) and have none of the mesh's other modifiers, so that only the
deformation differs.
"""

import bpy
import numpy as np
from mathutils import Matrix

from ..errors import SinewError
from ..live import frame, garments, session
from ..scene import armature_modifier, mesh_arrays, rest_body, rig_pose
from ..scene.lookup import objects_named

SINEW, LINEAR, PRESERVE_VOLUME, SMOOTH = "Sinew", "Linear", "Preserve Volume", "Corrective Smooth"
SMOOTH_ITERATIONS = 5
_ARMATURE_SETTINGS = ("use_vertex_groups", "use_bone_envelopes", "vertex_group", "invert_vertex_group")


class Deformers:
    """A skin under each deformer, moved by its rig or by a copy of the rig that can be posed freely.

    posed_freely: makes the copy. `remove` removes all temporary objects. Points are in metres, in the rig's axes.
    """

    def __init__(self, scene, skin, rig, posed_freely: bool):
        self._skin, self._rig = skin.name, rig.name
        self._objects: dict[str, str] = {}
        self._free_rig = ""
        try:
            if posed_freely:
                self._free_rig = _add(scene, rig, f"{rig.name} measured", rig.data).name
            moved_by = bpy.data.objects[self._free_rig or rig.name]
            for name in (LINEAR, PRESERVE_VOLUME, SMOOTH):
                self._objects[name] = _add_skin(scene, skin, moved_by, name).name
        except Exception:
            self.remove()
            raise
        bpy.context.view_layer.update()

    def remove(self):
        """Removes the temporary objects."""
        for name in (*self._objects.values(), self._free_rig):
            temporary = bpy.data.objects.get(name)
            if temporary:
                data = temporary.data
                bpy.data.objects.remove(temporary)
                if data.users == 0:  # the rest body of a mesh in shape keys
                    bpy.data.meshes.remove(data)

    @property
    def free_rig(self):
        """The copy of the rig that can be posed freely."""
        return objects_named([self._free_rig], "measure again")[0]

    def to_metres(self) -> np.ndarray:
        """(4, 4): the matrix from mesh space to metres in the rig's axes, at the current frame."""
        depsgraph = bpy.context.evaluated_depsgraph_get()
        rig, skin = (found.evaluated_get(depsgraph) for found in objects_named([self._rig, self._skin], "measure again"))
        size = rig.matrix_world.median_scale
        return np.array(Matrix.Scale(size, 4) @ rig.matrix_world.inverted_safe() @ skin.matrix_world)

    def points(self, sinew: "SinewDeformer | None") -> dict[str, np.ndarray]:
        """(vertices, 3) float32 by deformer, in the current pose. Sinew is first, if the mesh is bound."""
        depsgraph = bpy.context.evaluated_depsgraph_get()
        points_of = {}
        if sinew:
            (moved_by,) = objects_named([self._free_rig or self._rig], "measure again")
            points_of[SINEW] = sinew.points(moved_by.evaluated_get(depsgraph))
        for name, temporary in zip(self._objects, objects_named([*self._objects.values()], "measure again")):
            evaluated = temporary.evaluated_get(depsgraph)
            points_of[name] = mesh_arrays.read_evaluated_points(evaluated.data)
        matrix = self.to_metres()
        return {name: transformed(points, matrix) for name, points in points_of.items()}


class SinewDeformer:
    """Sinew's skin in any pose of its rig, with the tensions of the current frame. Nothing is written to the mesh."""

    def __init__(self, skin, rig, tissues: list):
        """Raises SinewError if the skin can't be bound."""
        depsgraph = bpy.context.evaluated_depsgraph_get()
        frame.frame(depsgraph)  # afterwards the handlers keep the tensions of the rig's state at the current frame
        try:
            self.rig_state = session.rig_state(rig, tissues, depsgraph)
            self._skin_state = garments.skin_state(depsgraph, rig, skin, self.rig_state)
        except ValueError as error:
            raise SinewError(f"{skin.name}: {error}") from error

    def points(self, evaluated_rig) -> np.ndarray:
        """(vertices, 3) float32, mesh space, in the pose of an evaluated rig."""
        pose = np.empty_like(self.rig_state.pose)
        rig_pose.read_pose(evaluated_rig, self.rig_state.rest, pose)
        out = np.empty_like(self._skin_state.points)
        self._skin_state.skin.deform(pose, self.rig_state.tension, out)
        return out


def transformed(points: np.ndarray, matrix: np.ndarray) -> np.ndarray:
    """(vertices, 3) float32: points transformed by a (4, 4) matrix."""
    return np.ascontiguousarray(points @ matrix[:3, :3].T + matrix[:3, 3], np.float32)


def _add(scene, original, name: str, data):
    """A temporary child of `original`. It is shown as bounds, because Blender does not evaluate hidden objects."""
    added = bpy.data.objects.new(name, data)
    scene.collection.objects.link(added)
    added.parent = original
    added.display_type = "BOUNDS"
    added.hide_select = added.hide_render = True
    return added


def _add_skin(scene, skin, rig, name: str):
    """A temporary object with the skin's mesh, moved by a rig under the deformer of this name."""
    added = _add(scene, skin, f"{skin.name} {name}", skin.data)
    if rest_body.key_values(skin):
        added.data = skin.data.copy()
        added.shape_key_clear()
        added.data.attributes["position"].data.foreach_set("vector", rest_body.read_points(skin).reshape(-1))
    else:
        added.show_only_shape_key = True  # the basis
        added.active_shape_key_index = 0
    modifier = added.modifiers.new("Armature", "ARMATURE")
    for original in armature_modifier.armature_modifiers(skin)[:1]:  # a second one differs in Preserve Volume alone
        for setting in _ARMATURE_SETTINGS:
            setattr(modifier, setting, getattr(original, setting))
    modifier.object = rig
    modifier.use_deform_preserve_volume = name == PRESERVE_VOLUME
    if name == SMOOTH:
        smooth = added.modifiers.new("Smooth", "CORRECTIVE_SMOOTH")
        smooth.rest_source, smooth.iterations = "ORCO", SMOOTH_ITERATIONS
    return added
