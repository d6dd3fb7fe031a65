# SPDX-License-Identifier: GPL-3.0-or-later
"""A bound skin is bound again when its mesh, its weights or its muscles change, and follows changed settings."""

import bpy
import numpy as np
from conftest import armature_alone, bend, evaluated_points, lifts, points_of_the_core, rest_points, select


def test_a_moved_vertex_is_bound_again(bent_skin):
    skin, rig = bent_skin
    bend(rig, 0.0)
    skin.data.vertices[0].co.z += 0.01
    bpy.context.view_layer.update()
    assert np.abs(evaluated_points(skin) - rest_points(skin)).max() <= 1e-6
    bend(rig, 1.2)
    assert lifts(skin).max() > 5e-4


def test_a_subdivided_mesh_is_bound_again(bent_skin):
    skin, rig = bent_skin
    select(skin)
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.ops.mesh.select_all(action="SELECT")
    bpy.ops.mesh.subdivide()
    bpy.ops.object.mode_set(mode="OBJECT")
    bpy.context.view_layer.update()
    assert lifts(skin).max() > 5e-4
    bend(rig, 0.0)
    assert np.abs(evaluated_points(skin) - rest_points(skin)).max() <= 1e-6


def test_painted_weights_are_bound_again(bent_skin):
    skin, rig = bent_skin
    index = int(np.argmax(np.linalg.norm(evaluated_points(skin) - rest_points(skin), axis=1)))
    for group in skin.vertex_groups:
        group.remove([index])
    skin.vertex_groups["upper"].add([index], 1.0, "REPLACE")
    bpy.context.view_layer.update()
    assert np.abs(evaluated_points(skin) - points_of_the_core(skin, rig)).max() <= 1e-5


def test_an_edited_muscle_is_bound_again(bent_skin):
    skin, _rig = bent_skin
    before = evaluated_points(skin)
    muscle = bpy.data.objects["Muscle lower"]
    muscle.scale.x *= 1.3
    muscle.scale.y *= 1.3
    bpy.context.view_layer.update()
    assert np.abs(evaluated_points(skin) - before).max() > 1e-4


def test_changed_settings_act_at_once(bent_skin):
    skin, _rig = bent_skin
    skin.sinew.skin.elastic = False  # because it moves the skin without swelling
    bpy.context.view_layer.update()
    before = evaluated_points(skin)
    skin.sinew.skin.muscle_influence = 0.0
    bpy.context.view_layer.update()
    assert np.abs(evaluated_points(skin) - armature_alone(skin)).max() == 0.0
    skin.sinew.skin.muscle_influence = 1.0
    bpy.context.view_layer.update()
    assert np.array_equal(evaluated_points(skin), before)
    skin.sinew.skin.live = False
    bpy.context.view_layer.update()
    assert np.abs(evaluated_points(skin) - before).max() > 5e-4
