# SPDX-License-Identifier: GPL-3.0-or-later
"""Keyed values at the times that Blender evaluates: subframes, other scenes, time remapping, bakes, disabled muscles."""

import bpy
import numpy as np
import pytest
from bl_ext.user_default.sinew.live import session
from bl_ext.user_default.sinew.scene import armature_modifier
from conftest import FLEXOR, add_muscle, bind, evaluated_points, make_arm, points_over, select
from evaluations import SUBFRAME, rendered, rendered_from_to

# bounds of a bake: its tolerance, and rounding of what plays it
TOLERANCE_MM, ROUNDING_M = 0.1, 1e-6


def keyed(name="Arm"):
    """(mesh, rig, muscle): an arm whose elbow bends, whose muscle moves, and whose settings change over frames 1 to 12."""
    skin, rig = make_arm(name)
    muscle = add_muscle(rig, name=f"{name} muscle", around=FLEXOR)
    bind(skin)
    bone = rig.pose.bones["lower"]
    bone.rotation_mode = "XYZ"
    for frame, angle, influence, x, tension in ((1, 0.3, 3.0, 0.0, 0.0), (12, 1.4, 1.0, 0.02, 1.0)):
        bone.rotation_euler[2] = angle
        bone.keyframe_insert("rotation_euler", frame=frame)
        skin.sinew.skin.muscle_influence = influence
        skin.keyframe_insert("sinew.skin.muscle_influence", frame=frame)
        muscle.location.x += x
        muscle.keyframe_insert("location", frame=frame)
        muscle.sinew.tissue.tension = tension
        muscle.keyframe_insert("sinew.tissue.tension", frame=frame)
    bpy.context.scene.frame_set(1)
    return skin, rig, muscle


def at(skin, frame: float):
    whole = int(frame // 1)
    bpy.context.scene.frame_set(whole, subframe=frame - whole)
    return evaluated_points(skin)


def remap():
    """Two frames of the animation pass in each frame of the scene."""
    scene = bpy.context.scene
    scene.render.frame_map_old, scene.render.frame_map_new = 100, 50
    scene.frame_set(1)


@pytest.fixture(params=["plain", "odd rate", "remapped"])
def timed(request):
    """(mesh, rig, muscle): the keyed arm in a scene with another frame rate or with Time Remapping."""
    scene = bpy.context.scene
    found = keyed()
    if request.param == "odd rate":
        scene.render.fps, scene.render.fps_base = 30, 1.001
    if request.param == "remapped":
        remap()
    return found


def test_frames_and_subframes_of_a_render_equal_the_window(timed, tmp_path):
    skin, *_ = timed
    points = rendered_from_to(skin, tmp_path, 2, end=8, step=3)
    assert sorted(points) == [2, 2 + SUBFRAME, 5, 5 + SUBFRAME, 8, 8 + SUBFRAME]
    for frame, of_render in points.items():
        assert np.array_equal(of_render, at(skin, frame)), frame


def test_a_render_of_another_scene_at_another_frame(tmp_path):
    skin, *_ = keyed()
    expected = at(skin, 9)
    bpy.context.scene.frame_set(3)
    shown = evaluated_points(skin)
    other = bpy.context.scene.copy()
    assert np.array_equal(rendered_from_to(skin, tmp_path, 9, scene=other)[9], expected)
    bpy.context.view_layer.update()
    assert np.array_equal(evaluated_points(skin), shown)
    assert not np.array_equal(shown, expected)


def test_baked_shape_keys_play_at_the_times_of_the_live_skin(timed):
    skin, *_ = timed
    frames = range(1, 7)
    live = points_over(skin, frames)
    select(skin)
    assert bpy.ops.sinew.bake_shape_keys(frame_start=1, frame_end=6, tolerance=TOLERANCE_MM) == {"FINISHED"}
    assert not skin.sinew.skin.live
    distances_mm = 1000.0 * np.abs(points_over(skin, frames) - live).max(axis=(1, 2))
    assert distances_mm.max() <= TOLERANCE_MM
    assert np.abs(live[-1] - live[0]).max() > 0.01


@pytest.mark.parametrize("step", [1, 2])
def test_a_point_cache_plays_at_the_times_of_the_live_skin(timed, tmp_path, step):
    skin, *_ = timed
    frames = range(1, 8, step)
    live = points_over(skin, frames)
    select(skin)
    assert bpy.ops.sinew.bake_cache(frame_start=1, frame_end=7, step=step, folder=str(tmp_path)) == {"FINISHED"}
    assert not skin.sinew.skin.live
    assert np.abs(points_over(skin, frames) - live).max() <= ROUNDING_M


def test_muscle_bones_play_at_the_times_of_the_live_skin():
    skin, rig, _muscle = keyed()
    skin.animation_data_clear()
    errors_m = []
    # the same six times, without and with Time Remapping
    for frames in (range(2, 13, 2), range(1, 7)):
        select(rig)
        made = bpy.ops.sinew.bake_bones(frame_start=frames[0], frame_end=frames[-1], step=frames.step, keyed=True)
        assert made == {"FINISHED"}
        copies = rig.sinew.rig.export_copy.all_objects
        copy = next(found for found in copies if found.type == "MESH" and armature_modifier.armature_modifiers(found))
        errors_m.append(np.abs(points_over(copy, frames) - points_over(skin, frames)).max())
        remap()
    assert abs(errors_m[1] - errors_m[0]) <= ROUNDING_M


def test_a_reach_is_keyed_at_the_times_of_its_goals():
    _skin, rig = make_arm()
    select(rig)
    bpy.context.view_layer.update()
    goal = bpy.data.objects.new("Goal", None)
    bpy.context.scene.collection.objects.link(goal)
    goal.sinew.goal.rig, goal.sinew.goal.bone = rig, "lower"
    for frame, place in ((1, (0.55, 0.1, 0.0)), (12, (0.3, 0.4, 0.0))):
        goal.location = place
        goal.keyframe_insert("location", frame=frame)
    remap()
    assert bpy.ops.sinew.bake_reach(frame_start=1, frame_end=6) == {"FINISHED"}
    (bag,) = rig.animation_data.action.layers[0].strips[0].channelbags
    for curve in bag.fcurves:
        assert [point.co.x for point in curve.keyframe_points] == [2.0, 4.0, 6.0, 8.0, 10.0, 12.0]


def disable(muscle):
    muscle.hide_viewport = muscle.hide_render = True


def exclude(muscle):
    collection = bpy.data.collections.new("Excluded")
    bpy.context.scene.collection.children.link(collection)
    for found in muscle.users_collection:
        found.objects.unlink(muscle)
    collection.objects.link(muscle)
    bpy.context.view_layer.layer_collection.children["Excluded"].exclude = True


@pytest.mark.parametrize("hide", [disable, exclude], ids=["disabled", "excluded"])
@pytest.mark.parametrize("is_pointed_at", [False, True])
def test_keys_of_a_muscle_that_blender_does_not_evaluate(tmp_path, hide, is_pointed_at):
    """Blender makes an evaluated copy of what another object points to, but never animates it."""
    skin, rig, muscle = keyed()
    muscle.keyframe_insert("rotation_euler", frame=1)
    muscle.rotation_euler.x += 0.5
    muscle.keyframe_insert("rotation_euler", frame=12)
    if is_pointed_at:
        select(muscle)
        bpy.ops.sinew.add_via_point()
    expected = [at(skin, frame) for frame in (1, 6, 12)]
    bpy.context.scene.frame_set(1)
    hide(muscle)
    bpy.context.view_layer.update()
    assert [np.array_equal(at(skin, frame), points) for frame, points in zip((1, 6, 12), expected)] == [True] * 3
    bpy.context.scene.frame_set(1)
    assert all(np.array_equal(*both) for both in zip(rendered(skin, tmp_path, 1, 6, 12), expected))
    assert session.reason(skin) == ""


@pytest.mark.parametrize("hide", [disable, exclude], ids=["disabled", "excluded"])
def test_a_driven_muscle_that_blender_does_not_evaluate_is_named(hide):
    _skin, rig, muscle = keyed()
    assert session.cached_rig(rig).problems == {}
    muscle.driver_add("scale", 0).driver.expression = "0.04"
    bpy.context.view_layer.update()
    assert session.cached_rig(rig).problems == {}
    hide(muscle)
    bpy.context.view_layer.update()
    assert "drivers" in session.cached_rig(rig).problems[muscle.name]
    muscle.hide_viewport = muscle.hide_render = False
    bpy.context.scene.collection.objects.link(muscle) if hide is exclude else None
    bpy.context.view_layer.update()
    assert session.cached_rig(rig).problems == {}


def test_a_driven_muscle_that_is_disabled_in_renders_is_named():
    _skin, rig, muscle = keyed()
    muscle.driver_add("scale", 0).driver.expression = "0.04"
    muscle.hide_render = True
    bpy.context.view_layer.update()
    assert "in renders" in session.cached_rig(rig).problems[muscle.name]
