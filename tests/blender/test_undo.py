# SPDX-License-Identifier: GPL-3.0-or-later
"""Undo and redo of a pose, a bind and Edit Rest Pose. The undo of other operators is tested with the operator."""

import bpy
import numpy as np
from conftest import FLEXOR, add_muscle, bend, bind, evaluated_points, select


def test_undo_and_redo(bent_skin):
    skin, rig = bent_skin
    bpy.ops.ed.undo_push(message="bent")
    before = evaluated_points(skin)
    bend(rig, 0.4)
    bpy.ops.ed.undo_push(message="less")
    less = evaluated_points(skin)
    bpy.ops.ed.undo()
    assert np.array_equal(evaluated_points(bpy.data.objects["Arm"]), before)
    bpy.ops.ed.redo()
    assert np.array_equal(evaluated_points(bpy.data.objects["Arm"]), less)


def test_undo_of_bind(arm):
    skin, rig = arm
    add_muscle(rig, around=FLEXOR)
    bpy.ops.ed.undo_push(message="muscle")
    bind(skin)
    bpy.ops.ed.undo_push(message="bind")
    bpy.ops.ed.undo()
    skin = bpy.data.objects["Arm"]
    assert not skin.sinew.skin.bound and [modifier.name for modifier in skin.modifiers] == ["Armature"]
    bend(bpy.data.objects["Arm Rig"], 1.0)
    bpy.ops.ed.redo()


def test_edit_rest_pose_is_undone(arm):
    _skin, rig = arm
    add_muscle(rig)
    select(rig)
    bpy.ops.ed.undo_push(message="before")
    bpy.ops.sinew.edit_rest_pose()
    bpy.ops.ed.undo_push(message="rest")
    bpy.ops.ed.undo()
    assert bpy.data.armatures["Arm Rig"].pose_position == "POSE"
