# SPDX-License-Identifier: GPL-3.0-or-later
"""Unbinding, removing and disabling: what stays in a character, and what a bake keeps."""

import bpy
import numpy as np
import pytest
from conftest import (
    add_muscle,
    armature_alone,
    bend,
    bind,
    delete_in_viewport,
    evaluated_points,
    make_arm,
    points_over,
    select,
    snapshot,
)
from test_bake_shape_keys import bake


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


def test_remove_keeps_other_keys_and_leaves_no_action(waving):
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
    for kept in ("settings", "custom"):  # the settings stay for the next bind
        del before[kept], after[kept]
    assert after == before


def test_muscle_display_leaves_no_trace_on_other_objects(waving):
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


def test_remove_deletes_the_action_of_a_keyed_tension(arm):
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


def test_baked_keys_play_after_unbind(waving):
    skin, _rig = waving
    live = points_over(skin, range(1, 13))
    bake(skin)
    skin.sinew.skin.live = True
    select(skin)
    bpy.ops.sinew.unbind()
    assert np.abs(points_over(skin, range(1, 13)) - live).max() < 1e-6


def test_remove_deletes_removed_muscles_and_their_via_points(human):
    delete_in_viewport("Sartorius.R")
    select(human)
    bpy.ops.sinew.remove()
    assert list(bpy.data.objects) == [human]


def test_a_disabled_extension_leaves_blenders_deformation(bent_skin):
    import addon_utils

    skin, _rig = bent_skin
    alone = armature_alone(skin)
    addon_utils.disable("bl_ext.user_default.sinew")
    bpy.context.view_layer.update()
    assert np.abs(evaluated_points(skin) - alone).max() == 0.0


@pytest.mark.parametrize("how", ["operator", "data"])
def test_remove_deletes_the_collection_of_muscles_that_were_deleted(arm, how):
    skin, rig = arm
    before = snapshot(skin, rig)
    muscle = add_muscle(rig)
    bind(skin)
    if how == "operator":
        delete_in_viewport(muscle.name)
    else:
        bpy.data.objects.remove(muscle)
        bpy.context.view_layer.update()
    select(rig)
    bpy.ops.sinew.remove()
    assert snapshot(skin, rig) == before


def test_remove_keeps_a_collection_that_the_user_filled(arm):
    _skin, rig = arm
    muscle = add_muscle(rig)
    (collection,) = muscle.users_collection
    lamp = bpy.data.objects.new("Lamp", None)
    collection.objects.link(lamp)
    select(rig)
    bpy.ops.sinew.remove()
    assert list(collection.objects) == [lamp]


@pytest.mark.parametrize("has_armature", [True, False])
def test_remove_after_a_bound_mesh_was_joined_into_another(arm, has_armature):
    skin, rig = arm
    other, own_rig = make_arm("Other")
    other.parent = rig if has_armature else None
    other.modifiers["Armature"].object = rig if has_armature else None
    bpy.data.objects.remove(own_rig)
    before = sorted(attribute.name for attribute in other.data.attributes)
    add_muscle(rig)
    bind(skin)
    bend(rig, 1.0)
    select(other, skin)
    bpy.ops.object.join()
    assert "sinew_correction" in other.data.attributes
    select(rig)
    bpy.ops.sinew.remove()
    assert sorted(attribute.name for attribute in other.data.attributes) == before
    assert not other.is_property_set("sinew") and not bpy.data.node_groups
