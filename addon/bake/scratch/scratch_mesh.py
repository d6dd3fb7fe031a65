# SPDX-License-Identifier: GPL-3.0-or-later
"""A temporary object that shows a skin's mesh at one point of its modifier stack, as Blender evaluates it.

So shape keys, drivers and other modifiers have the effect that they have in Blender.
"""

import bpy
import numpy as np

from ...errors import SinewError
from ...scene import armature_modifier, correction_modifier, mesh_arrays
from ...scene.lookup import objects_named
from ...settings import object_settings

BEFORE_ARMATURE, POSED = "BEFORE_ARMATURE", "POSED"


class ScratchMesh:
    """A copy of a live skin that shares its mesh and has the first of its modifiers. `remove` deletes it.

    points: BEFORE_ARMATURE keeps the modifiers up to Sinew's, whose points the Armature modifier poses. POSED keeps all
    modifiers up to the first that changes the number of vertices. `modifier_count`: the number of modifiers kept.
    `left_out`: for posed points, the names of the other modifiers that the viewport shows.
    """

    def __init__(self, scene, skin, points: str):
        added = skin.copy()
        self._name, self._skin, self._vertices = added.name, skin.name, len(skin.data.vertices)
        try:
            self._link(scene, added)
            self.modifier_count = self._limit_modifiers(skin, added, points)
        except Exception:
            self.remove()
            raise
        after = skin.modifiers[self.modifier_count :] if points == POSED else ()
        self.left_out = [modifier.name for modifier in after if modifier.show_viewport]

    def points(self, depsgraph) -> np.ndarray:
        """Returns the points in the current evaluation, (vertices, 3) float32, in the skin's object space.

        Raises SinewError if their number differs from the mesh's number of vertices.
        """
        (added,) = objects_named([self._name], "bake again")
        points = mesh_arrays.read_evaluated_points(added.evaluated_get(depsgraph).data)
        if len(points) != self._vertices:
            raise SinewError(
                f"{self._skin} has {len(points)} vertices instead of {self._vertices} in frame "
                f"{depsgraph.scene.frame_current}: a modifier changes their number, and a cache can't"
            )
        return points

    def remove(self):
        """Deletes the object."""
        added = bpy.data.objects.get(self._name)
        if added:
            bpy.data.objects.remove(added)

    def _link(self, scene, added):
        object_settings.clear(added)
        # Blender does not evaluate hidden objects.
        added.display_type = "BOUNDS"
        added.hide_viewport, added.hide_select, added.hide_render = False, True, True
        scene.collection.objects.link(added)

    def _limit_modifiers(self, skin, added, points: str) -> int:
        """Removes modifiers from the end of the stack and returns how many are left."""
        needed = skin.modifiers.find(correction_modifier.modifier_of(skin).name) + 1
        if points == POSED:
            armature = armature_modifier.armature_modifiers(skin)
            needed = max([needed, *(skin.modifiers.find(modifier.name) + 1 for modifier in armature)])
        else:
            self._keep_first(needed)
        while len(added.modifiers) > needed and self._count_vertices() != self._vertices:
            self._keep_first(len(added.modifiers) - 1)
        if self._count_vertices() != self._vertices:
            last = skin.modifiers[needed - 1].name
            raise SinewError(
                f"{skin.name}: a modifier before '{last}' changes the number of vertices, and a cache can't: "
                "move it further down"
            )
        return len(added.modifiers)

    def _keep_first(self, count: int):
        modifiers = bpy.data.objects[self._name].modifiers
        for modifier in modifiers[count:]:
            modifiers.remove(modifier)

    def _count_vertices(self) -> int:
        depsgraph = bpy.context.evaluated_depsgraph_get()
        depsgraph.update()
        return len(bpy.data.objects[self._name].evaluated_get(depsgraph).data.vertices)
