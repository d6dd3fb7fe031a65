# SPDX-License-Identifier: GPL-3.0-or-later
"""Unbinding and removing: what is left of Sinew in a character, and what a bake keeps."""

import bpy
import numpy as np
import pytest
from conftest import add_muscle, bend, bind, points_over, select, snapshot
from test_bake import bake


@pytest.mark.parametrize("baked", [False, True])
def test_remove_leaves_no_trace(arm, baked):
    skin, rig = arm
    before = snapshot(skin, rig)
    add_muscle(rig)
    bind(skin)
    if baked:
        bake(skin)
    select(rig)
    bpy.ops.sinew.remove()
    assert snapshot(skin, rig) == before
    bend(rig, 1.0)
    assert skin.sinew.tissue.kind == "NONE" and not skin.sinew.skin.bound


def test_remove_leaves_own_keys_and_no_action_of_its_own(waving):
    skin, rig = waving
    skin.shape_key_add(name="Basis")
    skin.shape_key_add(name="Smile")
    actions = sorted(action.name for action in bpy.data.actions)
    bake(skin)
    select(rig)
    bpy.ops.sinew.remove()
    assert [key.name for key in skin.data.shape_keys.key_blocks] == ["Basis", "Smile"]
    assert sorted(action.name for action in bpy.data.actions) == actions


def test_remove_can_keep_the_bake(waving):
    skin, rig = waving
    live = points_over(skin, range(1, 13))
    bake(skin)
    select(rig)
    bpy.ops.sinew.remove(keep_baked=True)
    assert np.abs(points_over(skin, range(1, 13)) - live).max() < 1e-6
    assert [modifier.name for modifier in skin.modifiers] == ["Armature"]


def test_unbind_leaves_the_mesh_as_it_was(arm):
    skin, rig = arm
    add_muscle(rig)
    before = snapshot(skin, rig)
    bind(skin)
    select(skin)
    bpy.ops.sinew.unbind()
    after = snapshot(skin, rig)
    for kept in ("settings", "custom"):  # what the person set stays for the next bind
        del before[kept], after[kept]
    assert after == before


def test_looking_leaves_no_trace_on_others_objects(waving):
    stranger = bpy.data.objects.new("Stranger", None)
    mesh = bpy.data.objects.new("Mesh", bpy.data.meshes.new("Mesh"))
    for found in (stranger, mesh):
        bpy.context.scene.collection.objects.link(found)
    bpy.context.scene.frame_set(4)
    assert not stranger.is_property_set("sinew") and not mesh.is_property_set("sinew")


def test_remove_after_unbind_leaves_no_trace(waving):
    skin, rig = waving
    select(skin)
    bake(skin)
    bpy.ops.sinew.unbind()
    select(rig)
    bpy.ops.sinew.remove()
    assert skin.data.shape_keys is None and not skin.is_property_set("sinew")


def test_remove_takes_the_action_of_a_keyed_tension(arm):
    skin, rig = arm
    before = snapshot(skin, rig)
    muscle = add_muscle(rig)
    bind(skin)
    muscle.sinew.tissue.keyframe_insert("tension", frame=1)
    select(rig)
    bpy.ops.sinew.remove()
    assert snapshot(skin, rig) == before


def test_remove_keeps_a_bake_that_plays_although_live_was_on(waving):
    skin, rig = waving
    live = points_over(skin, range(1, 13))
    bake(skin)
    skin.sinew.skin.live = True
    select(rig)
    bpy.ops.sinew.remove(keep_baked=True)
    assert np.abs(points_over(skin, range(1, 13)) - live).max() < 1e-6


def test_unbound_the_baked_keys_play(waving):
    skin, _rig = waving
    live = points_over(skin, range(1, 13))
    bake(skin)
    skin.sinew.skin.live = True
    select(skin)
    bpy.ops.sinew.unbind()
    assert np.abs(points_over(skin, range(1, 13)) - live).max() < 1e-6
