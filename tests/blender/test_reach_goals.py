# SPDX-License-Identifier: GPL-3.0-or-later
"""Goals as Empties, and baking a reach to keys."""

import bpy
import numpy as np
import pytest
from bl_ext.user_default.sinew.display import frame_times, timing_overlay
from bl_ext.user_default.sinew.reach import chains, goals
from conftest import add_muscle, bend, bind, select
from mathutils import Vector
from test_bone_recognition import KINDS, built
from test_reach import curves_of, make_chain, select_bones, world


def goal_of(rig, bone, **settings):
    """Adds a goal for a bone with the operator. The caller adds keys."""
    select_bones(rig, bone)
    before = set(bpy.data.objects)
    assert bpy.ops.sinew.add_goal() == {"FINISHED"}
    empty = (set(bpy.data.objects) - before).pop()
    for name, value in settings.items():
        setattr(empty.sinew.goal, name, value)
    return empty


def tail_positions(rig, bone, frames):
    places = []
    for frame in frames:
        bpy.context.scene.frame_set(frame)
        places.append(world(rig, bone))
    return np.array(places)


def test_a_goal_is_added_at_the_end_of_its_bone():
    rig = make_chain()
    rig.location, rig.scale = (1, 2, 3), (2, 2, 2)
    empty = goal_of(rig, "b3")
    bpy.context.view_layer.update()
    assert (empty.matrix_world.translation - world(rig, "b3")).length < 1e-5
    assert goals.goals_of(rig) == [empty]
    assert empty.sinew.tissue.kind == "NONE"


def test_a_bake_follows_keyed_goals_and_only_adds_rotation_keys():
    rig = make_chain()
    empty = goal_of(rig, "b3", chain_length=4)
    for frame, place in ((1, (0.6, 0.5, 0.6)), (12, (0.2, 0.7, 0.5)), (24, (0.6, 0.4, 0.9))):
        empty.location = place
        empty.keyframe_insert("location", frame=frame)
    bpy.context.scene.frame_set(5)
    assert bpy.ops.sinew.bake_reach(frame_start=1, frame_end=24, smoothness=0.001) == {"FINISHED"}
    assert bpy.context.scene.frame_current == 5
    frames = range(1, 25)
    reached = tail_positions(rig, "b3", frames)
    wanted = []
    for frame in frames:
        bpy.context.scene.frame_set(frame)
        wanted.append(tuple(empty.evaluated_get(bpy.context.evaluated_depsgraph_get()).matrix_world.translation))
    assert np.linalg.norm(reached - np.array(wanted), axis=1).max() < 2e-3
    # also with a selected goal
    bpy.ops.object.mode_set(mode="OBJECT")
    select(empty)
    assert bpy.ops.sinew.bake_reach(frame_start=1, frame_end=2) == {"FINISHED"}
    assert {curve.data_path.rpartition(".")[2] for curve in curves_of(rig)} == {"rotation_quaternion"}
    assert all(len(curve.keyframe_points) == 24 for curve in curves_of(rig))


def test_smoothness_removes_jitter():
    def jitter(smoothness):
        bpy.ops.wm.read_factory_settings(use_empty=True)
        rig = make_chain()
        empty = goal_of(rig, "b3", chain_length=4)
        for frame in range(1, 17):
            empty.location = (0.5 + 0.01 * (-1) ** frame, 0.6, 0.6)
            empty.keyframe_insert("location", frame=frame)
        bpy.ops.sinew.bake_reach(frame_start=1, frame_end=16, smoothness=smoothness)
        return np.abs(np.diff(tail_positions(rig, "b3", range(1, 17)), 2, axis=0)).max()

    assert jitter(1.0) < 0.3 * jitter(0.0)


def test_orientation_and_look_at_goals():
    rig = make_chain(6)
    turned = goal_of(rig, "b5", chain_length=6, orientation_weight=1.0)
    turned.rotation_mode = "XYZ"
    turned.location, turned.rotation_euler = (0.7, 0.6, 0.6), (0.3, 0.2, -1.0)
    bpy.ops.sinew.bake_reach(frame_start=1, frame_end=1)
    bpy.context.view_layer.update()
    made = (rig.matrix_world @ rig.pose.bones["b5"].matrix).to_quaternion()
    assert abs(made.dot(turned.matrix_world.to_quaternion())) > 1 - 1e-4
    turned.sinew.goal.position_weight = turned.sinew.goal.orientation_weight = 0.0
    turned.sinew.goal.look_at_weight, turned.sinew.goal.look_axis = 1.0, "-Z"
    turned.location = (0.0, 3.0, 1.0)
    bpy.ops.sinew.bake_reach(frame_start=1, frame_end=1)
    bpy.context.view_layer.update()
    bone = rig.pose.bones["b5"]
    sight = turned.location - rig.matrix_world @ bone.head
    assert (-(rig.matrix_world @ bone.matrix).col[2].to_3d()).angle(sight) < 1e-2


def test_pinned_feet_stay_while_the_pelvis_sinks():
    rig = built(*KINDS["Mixamo"])
    bpy.ops.object.mode_set(mode="POSE")
    hips = next(bone for bone in rig.pose.bones if bone.name.endswith("Hips"))
    inward = hips.bone.matrix_local.to_3x3().inverted()
    for frame, down in ((1, 0.0), (10, 0.12), (20, 0.05)):
        hips.location = inward @ Vector((0, 0, -down))
        hips.keyframe_insert("location", frame=frame)
    feet = [bone for (role, _), bone in chains.ends_of(rig).items() if role == "foot"]
    loose = tail_positions(rig, feet[0], range(1, 21))
    assert np.ptp(loose[:, 2]) > 0.1
    assert bpy.ops.sinew.bake_reach(frame_start=1, frame_end=20, pin_feet=True) == {"FINISHED"}
    for foot in feet:
        places = tail_positions(rig, foot, range(1, 21))
        assert np.abs(places - places[0]).max() < 1e-3
    assert np.ptp(tail_positions(rig, hips.name, range(1, 21))[:, 2]) > 0.1


def test_an_impossible_reach_bake_is_reported_and_changes_nothing():
    rig = make_chain()
    with pytest.raises(RuntimeError, match="has no goals"):
        bpy.ops.sinew.bake_reach(frame_start=1, frame_end=3)
    with pytest.raises(RuntimeError, match="no feet that Sinew recognises"):
        bpy.ops.sinew.bake_reach(frame_start=1, frame_end=3, pin_feet=True)
    empty = goal_of(rig, "b3")
    with pytest.raises(RuntimeError, match="The last frame is before the first"):
        bpy.ops.sinew.bake_reach(frame_start=3, frame_end=1)
    empty.sinew.goal.bone = "gone"
    with pytest.raises(RuntimeError, match="the bone 'gone', which Chain does not have"):
        bpy.ops.sinew.bake_reach(frame_start=1, frame_end=3)
    assert rig.animation_data is None


def test_remove_deletes_goals_and_eagerness():
    rig = make_chain()
    goal_of(rig, "b3").keyframe_insert("location", frame=1)
    rig.pose.bones["b1"].sinew.eagerness = 2.0
    bpy.ops.object.mode_set(mode="OBJECT")
    select(rig)
    bpy.ops.sinew.remove()
    assert goals.goals_of(rig) == [] and len(bpy.data.objects) == 1
    assert not rig.pose.bones["b1"].is_property_set("sinew")
    assert rig.pose.bones["b1"].sinew.eagerness == 1.0
    assert len(bpy.data.actions) == 0


def test_goals_and_eagerness_survive_a_file(tmp_path):
    rig = make_chain()
    empty = goal_of(rig, "b3", look_at_weight=0.3, chain_length=3)
    rig.pose.bones["b1"].sinew.eagerness = 2.0
    names = rig.name, empty.name
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "goals.blend"))
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "goals.blend"))
    rig, empty = (bpy.data.objects[name] for name in names)
    assert goals.goals_of(rig) == [empty]
    assert empty.sinew.goal.look_at_weight == pytest.approx(0.3) and rig.pose.bones["b1"].sinew.eagerness == 2.0


def test_times_are_measured_only_while_they_are_shown(arm):
    skin, rig = arm
    add_muscle(rig)
    bind(skin)
    manager = bpy.context.window_manager
    assert not manager.sinew_show_times
    bend(rig, 0.2)
    assert frame_times.means_ms() == {}
    manager.sinew_show_times = True
    try:
        bend(rig, 0.4)
        bend(rig, 0.6)
        means = frame_times.means_ms()
        assert set(means) == {"pose", "muscles", "skin", "total"}
        assert means["total"] == pytest.approx(sum(means[part] for part in ("pose", "muscles", "skin")), rel=0.2)
        assert frame_times.frames_per_second() > 0
        assert [line.split(":")[0] for line in timing_overlay.lines()[:4]] == ["Pose", "Muscles", "Skin", "Total"]
    finally:
        manager.sinew_show_times = False
    bend(rig, 0.8)
    assert frame_times.means_ms() == {}
