"""Rigify's human metarig with its forearms beside each other: the armature of Wilhelms' example of a hand."""

import bpy
from mathutils import Vector

SIDES = {".L": 1.0, ".R": -1.0}
BETWEEN_M = 0.24  # from one wrist to the other, so that the voxels of a skin over both hands are small


def make():
    """The armature, active, in a file in which Rigify is enabled."""
    bpy.ops.object.armature_human_metarig_add()
    rig = bpy.context.object
    bpy.ops.object.mode_set(mode="EDIT")
    bones = rig.data.edit_bones
    for side, sign in SIDES.items():
        limb = [bones[f"forearm{side}"], *bones[f"forearm{side}"].children_recursive]
        moved = Vector((sign * BETWEEN_M / 2, 0.0, 0.0)) - bones[f"hand{side}"].head
        for bone in limb:
            bone.use_connect = False
        for bone in limb:
            bone.head, bone.tail = bone.head + moved, bone.tail + moved
    bpy.ops.object.mode_set(mode="OBJECT")
    rig.name = "Hands"
    return rig
