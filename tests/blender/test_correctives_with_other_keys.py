# SPDX-License-Identifier: GPL-3.0-or-later
"""Correctives together with Live, other shape keys, baked frames and keyed poses, and their removal."""

import math

import bpy
import numpy as np
import pytest
from conftest import add_muscle, bind, evaluated_points, key_bend, select, snapshot
from test_correctives import EXACT_MM, TOLERANCE_MM, apart_mm, bake, keys_of, pose


def test_live_and_correctives_do_not_add_up(muscled):
    skin, rig = muscled
    pose(rig, ("lower", "Z", 90.0))
    live = evaluated_points(skin)
    bake(skin)
    skin.sinew.skin.live = True
    bpy.context.view_layer.update()
    assert np.abs(evaluated_points(skin) - live).max() < 1e-6


def test_other_keys_and_drivers_stay(muscled):
    skin, rig = muscled
    skin.shape_key_add(name="Basis")
    own = skin.shape_key_add(name="Smile")
    for point in own.points:
        point.co.z += 0.01
    own.driver_add("value").driver.expression = "0.5"
    bake(skin)
    name, turns = max(keys_of(skin).items(), key=lambda item: item[1][0][2])
    pose(rig, *turns)
    assert apart_mm(skin) < EXACT_MM
    select(rig)
    bpy.ops.sinew.remove()
    assert [key.name for key in skin.data.shape_keys.key_blocks] == ["Basis", "Smile"]
    assert [curve.data_path for curve in skin.data.shape_keys.animation_data.drivers] == ['key_blocks["Smile"].value']


def test_remove_leaves_no_trace(arm):
    skin, rig = arm
    before = snapshot(skin, rig)
    add_muscle(rig)
    bind(skin)
    bake(skin)
    select(rig)
    bpy.ops.sinew.remove()
    assert snapshot(skin, rig) == before


def test_kept_keys_play_after_remove(muscled):
    skin, rig = muscled
    pose(rig, ("lower", "Z", 140.0))
    live = evaluated_points(skin)
    bake(skin)
    select(rig)
    bpy.ops.sinew.remove(keep_baked=True)
    assert np.abs(evaluated_points(skin) - live).max() < 1e-5


def test_a_new_bake_replaces_the_keys_of_its_joints(muscled):
    skin, _rig = muscled
    bake(skin)
    bake(skin, tolerance=2.0, prefix="other ")
    names = [key.name for key in skin.data.shape_keys.key_blocks]
    assert all(name.startswith("other ") for name in names[1:])
    assert len(skin.data.shape_keys.animation_data.drivers) == len(names) - 1 == len(skin.sinew.skin.baked_keys)


def test_frames_and_correctives_do_not_add_up(muscled):
    skin, rig = muscled
    key_bend(rig, {1: 0.2, 6: 1.4})
    bpy.context.scene.frame_set(6)
    live = evaluated_points(skin)
    bake(skin)
    bpy.ops.sinew.bake_shape_keys(frame_start=1, frame_end=6, tolerance=0.0)
    bpy.context.scene.frame_set(6)
    assert np.abs(evaluated_points(skin) - live).max() < 1e-6
    bake(skin, angles=f"Z 0..{math.degrees(1.4)}")
    assert 1000.0 * np.abs(evaluated_points(skin) - live).max() < EXACT_MM


def test_a_keyed_pose_does_not_change(muscled):
    skin, rig = muscled
    bone = rig.pose.bones["lower"]
    bone.rotation_mode = "XYZ"
    bone.rotation_euler[2] = 0.8
    bone.keyframe_insert("rotation_euler", frame=1)
    bone.rotation_euler[2] = 1.1  # not keyed yet
    bpy.context.view_layer.update()
    live = evaluated_points(skin)
    objects = sorted(found.name for found in bpy.data.objects)
    bake(skin)
    assert bone.rotation_euler[2] == pytest.approx(1.1) and sorted(found.name for found in bpy.data.objects) == objects
    assert 1000.0 * np.linalg.norm(evaluated_points(skin) - live, axis=1).max() < 1.1 * TOLERANCE_MM


def test_a_cancelled_bake_of_correctives_leaves_nothing(muscled):
    from bl_ext.user_default.sinew.bake.correctives.correctives import CorrectiveBake, Settings

    skin, rig = muscled
    pose(rig, ("lower", "Z", 40.0))
    before, seen = snapshot(skin, rig), evaluated_points(skin)
    settings = Settings(["lower"], False, ["Z 0..140"], False, TOLERANCE_MM, 0.002, 0, 4, "sinew ")
    half = CorrectiveBake(rig, [skin], bpy.context.scene, settings)
    steps = half.steps()
    for _ in range(20):
        next(steps)
    half.cancel()
    assert snapshot(skin, rig) == before and skin.sinew.skin.live
    assert np.array_equal(evaluated_points(skin), seen)
