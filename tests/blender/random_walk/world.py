# SPDX-License-Identifier: GPL-3.0-or-later
"""The scene of the random walk, and the choices that its steps make. Nothing is kept between two steps except names."""

import random
from pathlib import Path

import bpy
from bl_ext.user_default.sinew.scene import armature_modifier, tissue_empty
from conftest import FLEXOR, add_muscle, bend, bind, make_arm, select


class Nothing(Exception):
    """The step has nothing to act on."""


class World:
    """Random choices among what the file holds at the moment, in an order that does not depend on memory."""

    def __init__(self, seed: int, folder: Path):
        self.random, self.folder = random.Random(seed), folder
        self.saved = 0

    def build(self):
        """Two bent arms with muscles, and a cube that has nothing to do with them."""
        bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
        for name, x in (("A", 0.0), ("B", 1.0)):
            skin, rig = make_arm(name, rings=12, around=10)
            rig.location.y = x
            add_muscle(rig, name="Biceps", around=FLEXOR)
            add_muscle(rig, name="Triceps", around=-FLEXOR)
            select(rig)
            bpy.ops.sinew.add_tissue(kind="SPHERE", origin_bone="lower", name="Elbow")
            bind(skin)
            bend(rig, 1.0 + x)
        bpy.ops.mesh.primitive_cube_add(size=0.2, location=(0.0, -1.0, 0.0))
        bpy.ops.ed.undo_push(message="start")

    def pick(self, found):
        """One of these. Raises Nothing if there are none."""
        found = list(found)
        if not found:
            raise Nothing
        return self.random.choice(found)

    def number(self, low: float, high: float) -> float:
        return self.random.uniform(low, high)

    def chance(self, share: float = 0.5) -> bool:
        return self.random.random() < share

    def objects(self, kind: str):
        """The local objects of a type in the view layer, sorted by name."""
        found = [each for each in bpy.context.view_layer.objects if each.type == kind and each.library is None]
        return sorted(found, key=lambda each: each.name)

    def skin(self, editable: bool = False):
        """A bound mesh. editable: its data can be changed."""
        return self.pick(
            each
            for each in self.objects("MESH")
            if armature_modifier.is_bound(each) and not (editable and (each.data.library or each.data.is_editmode))
        )

    def mesh(self):
        return self.pick(each for each in self.objects("MESH") if not (each.data.library or each.data.is_editmode))

    def rig(self):
        return self.pick(self.objects("ARMATURE"))

    def bone(self, rig):
        return self.pick(sorted(rig.pose.bones, key=lambda bone: bone.name))

    def tissue(self, kind: str = ""):
        """The Empty of a tissue."""
        return self.pick(
            each
            for each in self.objects("EMPTY")
            if tissue_empty.is_tissue(each) and (not kind or each.sinew.tissue.kind == kind)
        )

    def to_object_mode(self):
        active = bpy.context.view_layer.objects.active
        if active and active.mode != "OBJECT":
            bpy.ops.object.mode_set(mode="OBJECT")

    def activate(self, *objects):
        """Selects objects in Object Mode. Hidden ones can't be selected."""
        self.to_object_mode()
        for each in objects:
            each.hide_set(False)
            if each.hide_viewport or not each.visible_get():
                raise Nothing
        select(*objects)
