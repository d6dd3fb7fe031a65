# SPDX-License-Identifier: GPL-3.0-or-later
"""Renaming, duplicating and deleting objects and bones of a bound character."""

import bpy
import numpy as np
from bl_ext.user_default.sinew.live import session
from conftest import EXTENSOR, add_muscle, bend, evaluated_points, lifts, select


def test_duplicate(bent_skin):
    skin, rig = bent_skin
    select(skin, rig, *[found for found in bpy.data.objects if found.type == "EMPTY"])
    bpy.ops.object.duplicate()
    twin = next(found for found in bpy.context.selected_objects if found.type == "MESH")
    twin_rig = next(found for found in bpy.context.selected_objects if found.type == "ARMATURE")
    bpy.context.view_layer.update()
    assert np.abs(evaluated_points(twin) - evaluated_points(skin)).max() <= 1e-6
    bend(twin_rig, 0.2)
    assert np.abs(evaluated_points(twin) - evaluated_points(skin)).max() > 1e-3
    bend(twin_rig, 1.2)
    assert np.abs(evaluated_points(twin) - evaluated_points(skin)).max() <= 1e-6
    assert lifts(twin).max() > 5e-4


def test_renamed_objects_stay_bound(bent_skin):
    skin, rig = bent_skin
    before = evaluated_points(skin)
    skin.name, rig.name, bpy.data.objects["Muscle lower"].name = "Skin", "Rigged", "Biceps"
    bend(rig, 0.3)
    bend(rig, 1.2)
    assert np.array_equal(evaluated_points(skin), before)


def test_a_renamed_bone_keeps_its_muscle(bent_skin):
    skin, rig = bent_skin
    before = evaluated_points(skin)
    rig.data.bones["lower"].name = "forearm"
    rig.data.bones["upper"].name = "humerus"
    bpy.context.view_layer.update()
    muscle = bpy.data.objects["Muscle lower"]
    assert (muscle.sinew.tissue.origin_bone, muscle.sinew.tissue.insertion_bone) == ("humerus", "forearm")
    bend(rig, 0.3, bone="forearm")
    bend(rig, 1.2, bone="forearm")
    assert np.array_equal(evaluated_points(skin), before)


def test_a_removed_bone_is_named_and_other_muscles_work(bent_skin):
    skin, rig = bent_skin
    other = add_muscle(rig, name="Other", around=EXTENSOR)
    other.sinew.tissue.insertion_bone = "gone"
    bpy.context.view_layer.update()
    assert lifts(skin).max() > 5e-4
    problems = session.cached_rig(rig).problems
    assert list(problems) == ["Other"] and "gone" in problems["Other"]


def test_a_deleted_muscle_no_longer_acts(bent_skin):
    skin, _rig = bent_skin
    bpy.data.objects.remove(bpy.data.objects["Muscle lower"])
    bpy.context.view_layer.update()
    bpy.context.scene.frame_set(2)
    assert lifts(skin).max() == 0.0
    assert "muscles" in session.reason(skin)
