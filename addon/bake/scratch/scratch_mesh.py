# SPDX-License-Identifier: GPL-3.0-or-later
"""A temporary object that shows a skin's mesh as it leaves a place in the stack of modifiers, by Blender's own evaluation.

So shape keys, drivers and other modifiers are as Blender has them, whatever they are.
"""

import bpy
import numpy as np

from ...errors import SinewError
from ...scene import armature_modifier, correction_modifier, mesh_arrays
from ...settings import object_settings

BEFORE_ARMATURE, POSED = "BEFORE_ARMATURE", "POSED"


class ScratchMesh:
    """A copy of a live skin that shares its mesh and has the first of its modifiers; `remove` takes it away.

    points: BEFORE_ARMATURE, the modifiers up to Sinew's own, whose points the Armature modifier poses; or POSED, all up
    to the first that changes the number of vertices. `place`: how many modifiers these are. `left_out`: the names of the
    others that the viewport shows, where points are to be posed.
    """

    def __init__(self, scene, skin, points: str):
        added = skin.copy()
        self._name, self._skin, self._vertices = added.name, skin.name, len(skin.data.vertices)
        try:
            self._link(scene, added)
            self.place = self._settle(skin, added, points)
        except Exception:
            self.remove()
            raise
        after = skin.modifiers[self.place :] if points == POSED else ()
        self.left_out = [modifier.name for modifier in after if modifier.show_viewport]

    def points(self, depsgraph) -> np.ndarray:
        """(vertices, 3) float32, the skin's object space, as things stand in an evaluation.

        Raises SinewError where the number of vertices is another than that of the mesh.
        """
        points = mesh_arrays.read_evaluated_points(bpy.data.objects[self._name].evaluated_get(depsgraph).data)
        if len(points) != self._vertices:
            raise SinewError(
                f"{self._skin} has {len(points)} vertices instead of {self._vertices} in frame "
                f"{depsgraph.scene.frame_current}: a modifier changes their number, and a cache can't"
            )
        return points

    def remove(self):
        """Takes the object away."""
        found = bpy.data.objects.get(self._name)
        if found:
            bpy.data.objects.remove(found)

    def _link(self, scene, added):
        object_settings.clear(added)
        # what is hidden is not evaluated
        added.display_type = "BOUNDS"
        added.hide_viewport, added.hide_select, added.hide_render = False, True, True
        scene.collection.objects.link(added)

    def _settle(self, skin, added, points: str) -> int:
        """Removes modifiers from the end; returns how many are left."""
        needed = skin.modifiers.find(correction_modifier.modifier_of(skin).name) + 1
        if points == POSED:
            needed = max(
                [
                    needed,
                    *(skin.modifiers.find(modifier.name) + 1 for modifier in armature_modifier.armature_modifiers(skin)),
                ]
            )
        else:
            self._keep(needed)
        while len(added.modifiers) > needed and self._count() != self._vertices:
            self._keep(len(added.modifiers) - 1)
        if self._count() != self._vertices:
            last = skin.modifiers[needed - 1].name
            raise SinewError(
                f"{skin.name}: a modifier before '{last}' changes the number of vertices, and a cache can't: move it further down"
            )
        return len(added.modifiers)

    def _keep(self, count: int):
        modifiers = bpy.data.objects[self._name].modifiers
        for modifier in modifiers[count:]:
            modifiers.remove(modifier)

    def _count(self) -> int:
        depsgraph = bpy.context.evaluated_depsgraph_get()
        depsgraph.update()
        return len(bpy.data.objects[self._name].evaluated_get(depsgraph).data.vertices)
