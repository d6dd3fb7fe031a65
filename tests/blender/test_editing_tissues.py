# SPDX-License-Identifier: GPL-3.0-or-later
"""Editing tissues: the rest pose, sizes, the offset, copied settings, and the tension of hidden muscles."""

import math

import bpy
import numpy as np
import pytest
from bl_ext.user_default.sinew.live import session
from bl_ext.user_default.sinew.scene import tissue_empty
from conftest import add_muscle, bend, bind, evaluated_points, select
from mathutils import Quaternion, Vector


def pose_of(rig):
    return [tuple(map(tuple, bone.matrix_basis)) for bone in rig.pose.bones]


def test_edit_rest_pose_and_back(arm):
    skin, rig = arm
    empty = add_muscle(rig, around=math.pi / 2)
    bind(skin)
    bend(rig, 1.2)
    pose, points, shown = pose_of(rig), evaluated_points(skin), empty.matrix_world.copy()
    select(rig)
    bpy.ops.sinew.edit_rest_pose()
    bpy.context.view_layer.update()
    assert rig.data.pose_position == "REST"
    assert tuple(empty.delta_location) == (0, 0, 0) and tuple(empty.delta_scale) == (1, 1, 1)
    centre = tissue_empty.read(empty, rig).centre
    assert (empty.matrix_world.translation - rig.matrix_world @ centre).length < 1e-6
    bpy.ops.sinew.edit_rest_pose()
    bpy.context.view_layer.update()
    assert rig.data.pose_position == "POSE" and pose_of(rig) == pose
    assert np.array_equal(evaluated_points(skin), points)
    assert max(abs(a - b) for x, y in zip(empty.matrix_world, shown) for a, b in zip(x, y)) < 1e-6


def test_a_tense_muscle_is_edited_in_its_rest_shape(arm):
    _skin, rig = arm
    empty = add_muscle(rig)
    empty.sinew.tissue.tension = 1.0
    bpy.context.view_layer.update()
    assert tuple(empty.delta_scale) != (1, 1, 1)
    select(rig)
    bpy.ops.sinew.edit_rest_pose()
    bpy.context.view_layer.update()
    assert tuple(empty.delta_scale) == (1, 1, 1)


def test_sizes_are_those_of_the_empty(arm):
    _skin, rig = arm
    empty = add_muscle(rig)
    own = empty.sinew.tissue
    own.semi_axes = (0.02, 0.03, 0.1)
    assert tuple(empty.scale) == pytest.approx((0.02, 0.03, 0.1))
    own.width_ratio = 1.5
    assert own.width_ratio == pytest.approx(1.5) and empty.scale.x * empty.scale.y == pytest.approx(6e-4)
    empty.empty_display_size = 2.0
    assert tuple(own.semi_axes) == pytest.approx((2 * empty.scale.x, 2 * empty.scale.y, 0.2))


def test_offset_is_the_distance_from_the_bone(arm):
    _skin, rig = arm
    empty = add_muscle(rig, around=0.7)
    before = tissue_empty.read(empty, rig)
    empty.sinew.tissue.offset = 0.08
    after = tissue_empty.read(empty, rig)
    assert math.hypot(after.centre.y, after.centre.z) == pytest.approx(0.08, abs=1e-6)
    assert after.centre.x == pytest.approx(before.centre.x, abs=1e-6)
    assert after.centre.yz.angle(before.centre.yz) < 1e-4
    assert empty.sinew.tissue.offset == pytest.approx(0.08, abs=1e-6)


def test_copy_settings(arm):
    _skin, rig = arm
    source, other = add_muscle(rig, name="A"), add_muscle(rig, name="B", around=2.0)
    source.sinew.tissue.origin_tendon, source.sinew.tissue.tension, source.sinew.tissue.volume_keeping = 0.05, 0.4, 0.7
    source.scale = (0.01, 0.02, 0.1)
    length = other.scale.z
    select(source, other)
    bpy.ops.sinew.copy_settings()
    assert other.sinew.tissue.origin_tendon == pytest.approx(0.05) and other.sinew.tissue.tension == pytest.approx(0.4)
    assert other.scale.x != pytest.approx(0.01)
    bpy.ops.sinew.copy_settings(widths=True)
    assert tuple(other.scale) == pytest.approx((0.01, 0.02, length))
    select(source)
    with pytest.raises(RuntimeError, match="Select other tissues"):
        bpy.ops.sinew.copy_settings()


def tension_at(rig, frame):
    bpy.context.scene.frame_set(frame)
    return float(session.cached_rig(rig).tension[0])


@pytest.mark.parametrize("hide", ["shown", "hidden", "disabled", "excluded", "unlinked"])
def test_keyed_tension_acts_however_the_muscle_is_hidden(arm, hide):
    skin, rig = arm
    empty = add_muscle(rig)
    bind(skin)
    for frame, value in ((1, 0.0), (11, 1.0)):
        empty.sinew.tissue.tension = value
        empty.keyframe_insert("sinew.tissue.tension", frame=frame)
    hide_as(empty, hide)
    seen = [tension_at(rig, frame) for frame in (1, 6, 11)]
    assert seen == pytest.approx([0.0, 0.5, 1.0], abs=1e-6)


@pytest.mark.parametrize(("hide", "acts"), [("shown", True), ("hidden", True), ("disabled", False)])
def test_driven_tension_acts_where_blender_evaluates_the_muscle(arm, hide, acts):
    """Drivers act on muscles hidden with H, but not on muscles disabled in viewports. The tooltip says so."""
    skin, rig = arm
    empty = add_muscle(rig)
    bind(skin)
    empty.driver_add("sinew.tissue.tension").driver.expression = "frame / 10"
    hide_as(empty, hide)
    first, second = tension_at(rig, 2), tension_at(rig, 6)
    assert (second - first == pytest.approx(0.4, abs=1e-6)) == acts


def hide_as(empty, hide):
    if hide == "hidden":
        empty.hide_set(True)
    elif hide == "disabled":
        empty.hide_viewport = True
    elif hide == "excluded":
        layer = bpy.context.view_layer.layer_collection.children[empty.users_collection[0].name]
        layer.exclude = True
    elif hide == "unlinked":
        empty.users_collection[0].objects.unlink(empty)


def test_another_origin_bone_leaves_a_tissue_where_it_is(arm):
    _, rig = arm
    muscle = add_muscle(rig)
    before = tissue_empty.read(muscle, rig)
    muscle.sinew.tissue.origin_bone = "lower"
    after = tissue_empty.read(muscle, rig)
    assert after.origin_bone == "lower"
    assert (after.origin - before.origin).length < 1e-6
    assert (after.insertion - before.insertion).length < 1e-6


@pytest.mark.parametrize("order", ["XYZ", "XZY", "YXZ", "YZX", "ZXY", "ZYX"])
def test_a_rotation_near_90_degrees_is_written_exactly(arm, order):
    _, rig = arm
    muscle = add_muscle(rig)
    muscle.rotation_mode = order
    for angle in (1.5, 1.57, 1.5707, -1.5706):
        middle = Quaternion(tuple(float(axis == order[1]) for axis in "XYZ"), angle)
        wanted = Quaternion(tuple(float(axis == order[0]) for axis in "XYZ"), 0.9) @ middle
        muscle.rotation_euler = tissue_empty._euler_of(wanted, order)
        error = wanted.rotation_difference(muscle.rotation_euler.to_quaternion())
        assert Vector((error.x, error.y, error.z)).length < 1e-6
