# SPDX-License-Identifier: GPL-3.0-or-later
"""The live skin: laws of one frame, evaluated by Blender."""

import bpy
import numpy as np
import pytest
from conftest import (
    FLEXOR,
    add_muscle,
    armature_alone,
    bend,
    bind,
    evaluated_points,
    key_bend,
    make_arm,
    points_of_the_core,
    rest_points,
    select,
)
from mathutils import Matrix, Vector


def test_the_rest_pose_shows_the_rest_mesh(arm):
    skin, rig = arm
    add_muscle(rig)
    bind(skin)
    assert np.abs(evaluated_points(skin) - rest_points(skin)).max() <= 1e-6


def test_a_bent_elbow_swells_the_skin(arm):
    skin, rig = arm
    skin.sinew.skin.elastic = False
    add_muscle(rig, around=FLEXOR)
    bind(skin)
    bend(rig, 1.2)
    moved = np.linalg.norm(evaluated_points(skin) - armature_alone(skin), axis=1)
    assert 0.5e-3 < moved.max() < 0.05


def test_returning_to_the_rest_pose_leaves_no_trace(arm):
    skin, rig = arm
    add_muscle(rig)
    bind(skin)
    bend(rig, 1.2)
    assert np.abs(evaluated_points(skin) - rest_points(skin)).max() > 1e-2
    bend(rig, 0.0)
    assert np.abs(evaluated_points(skin) - rest_points(skin)).max() <= 1e-6


@pytest.mark.parametrize("preserve_volume", [False, True])
def test_skin_far_from_tissues_follows_blender_alone(arm, preserve_volume):
    skin, rig = arm
    skin.modifiers["Armature"].use_deform_preserve_volume = preserve_volume
    muscle = add_muscle(rig)
    muscle.scale = (0.004, 0.004, 0.01)
    skin.sinew.skin.falloff, skin.sinew.skin.elastic = 0.01, False
    bind(skin)
    bend(rig, 1.0)
    rig.pose.bones["lower"].scale = (1.1, 0.9, 1.0)
    bpy.context.view_layer.update()
    assert np.abs(evaluated_points(skin) - armature_alone(skin)).max() <= 1e-5


@pytest.mark.parametrize("carry", ["SWELLING", "FULL"])
@pytest.mark.parametrize("anchoring", ["BLENDED", "NEAREST"])
@pytest.mark.parametrize("preserve_volume", [False, True])
@pytest.mark.parametrize("elastic", [False, True])
def test_live_points_equal_the_cores(arm, carry, anchoring, preserve_volume, elastic):
    """The points after the Armature modifier equal the skin that the core computes (docs/mathematics/correction.md)."""
    skin, rig = arm
    skin.modifiers["Armature"].use_deform_preserve_volume = preserve_volume
    skin.sinew.skin.motion_source, skin.sinew.skin.anchoring, skin.sinew.skin.elastic = carry, anchoring, elastic
    add_muscle(rig, around=FLEXOR)
    bind(skin)
    bend(rig, 1.1)
    rig.pose.bones["upper"].scale = (1.0, 1.05, 0.95)
    bpy.context.view_layer.update()
    assert np.abs(evaluated_points(skin) - points_of_the_core(skin, rig)).max() <= 1e-5


def test_a_moved_turned_and_scaled_rig_moves_the_skin_with_it(arm):
    skin, rig = arm
    add_muscle(rig)
    bind(skin)
    bend(rig, 1.0)
    before = evaluated_points(skin)
    rig.matrix_world = Matrix.Translation((3, -2, 1)) @ Matrix.Rotation(0.7, 4, "X") @ Matrix.Scale(2.0, 4)
    bpy.context.view_layer.update()
    assert np.abs(evaluated_points(skin) - before).max() <= 1e-5


def test_a_rig_moved_by_its_root_bone_moves_the_skin_rigidly(arm):
    skin, rig = arm
    add_muscle(rig)
    bind(skin)
    turn = Matrix.Translation((0.2, 0.1, -0.3)) @ Matrix.Rotation(1.0, 4, Vector((1, 2, 3)).normalized())
    rest = rig.data.bones["upper"].matrix_local
    rig.pose.bones["upper"].matrix_basis = rest.inverted() @ turn @ rest
    bpy.context.view_layer.update()
    wanted = rest_points(skin) @ np.array(turn.to_3x3()).T + np.array(turn.translation)
    assert np.abs(evaluated_points(skin) - wanted).max() <= 2e-6


def test_a_mesh_of_another_scale_deforms_the_same(arm):
    """A mesh object with a non-uniform scale over the same rig has the same points in world space."""
    skin, rig = arm
    add_muscle(rig, around=FLEXOR)
    bind(skin)
    bend(rig, 1.2)
    plain = evaluated_points(skin) @ np.array(skin.matrix_world.to_3x3()).T
    bend(rig, 0.0)
    into = Matrix.LocRotScale(Vector((0.1, 0.2, 0.3)), Matrix.Rotation(0.4, 3, "Z"), Vector((2.0, 0.5, 1.5)))
    skin.data.transform(into.inverted())
    skin.parent = None
    skin.matrix_world = into
    bpy.context.view_layer.update()
    bend(rig, 1.2)
    points = evaluated_points(skin)
    world = points @ np.array(into.to_3x3()).T + np.array(into.translation)
    assert np.abs(world - plain).max() <= 5e-6


def test_frames_are_the_same_bits_in_any_order(arm):
    skin, rig = arm
    add_muscle(rig)
    key_bend(rig, {1: 0.0, 20: 1.5})
    bind(skin)
    scene = bpy.context.scene

    def points_at(frame):
        scene.frame_set(frame)
        return evaluated_points(skin).tobytes()

    forward = [points_at(frame) for frame in range(1, 21)]
    backward = [points_at(frame) for frame in range(20, 0, -1)][::-1]
    assert forward == backward
    assert len(set(forward)) == 20


def test_tension_thickens_at_rest_and_can_be_keyed(arm):
    skin, rig = arm
    muscle = add_muscle(rig, around=FLEXOR)
    bind(skin)
    muscle.sinew.tissue.tension = 1.0
    bpy.context.view_layer.update()
    assert np.abs(evaluated_points(skin) - rest_points(skin)).max() > 5e-4
    muscle.sinew.tissue.tension = 0.0
    muscle.sinew.tissue.keyframe_insert("tension", frame=1)
    muscle.sinew.tissue.tension = 1.0
    muscle.sinew.tissue.keyframe_insert("tension", frame=10)
    bpy.context.scene.frame_set(1)
    assert np.abs(evaluated_points(skin) - rest_points(skin)).max() <= 1e-6
    bpy.context.scene.frame_set(10)
    assert np.abs(evaluated_points(skin) - rest_points(skin)).max() > 5e-4


def test_muscles_shown_follow_the_pose_and_keep_their_volume(arm):
    skin, rig = arm
    muscle = add_muscle(rig, around=FLEXOR)
    rest_scale = muscle.scale.copy()
    rest = muscle.matrix_world.copy()
    bend(rig, 1.2)
    now = muscle.matrix_world
    assert (now.translation - rest.translation).length > 1e-3
    assert abs(now.to_3x3().determinant() / rest.to_3x3().determinant() - 1.0) <= 1e-5
    assert now.to_scale().z < 0.99 * rest.to_scale().z
    assert muscle.scale == rest_scale  # the values of the user do not change
    bend(rig, 0.0)
    assert max(abs(a - b) for a, b in zip(sum(map(list, muscle.matrix_world), []), sum(map(list, rest), []))) <= 1e-5


def test_shape_keys_of_the_mesh_play_as_well(arm):
    skin, rig = arm
    add_muscle(rig, around=FLEXOR)
    skin.shape_key_add(name="Basis")
    key = skin.shape_key_add(name="Raised")
    key.value = 0.0
    for point in key.points:
        point.co.z += 0.01
    bind(skin)
    bend(rig, 1.2)
    plain = evaluated_points(skin)
    key.value = 1.0
    bpy.context.view_layer.update()
    raised = evaluated_points(skin)
    assert np.abs(raised - plain - np.array((0.0, 0.0, 0.01))).max() < 1e-5
    assert [block.name for block in skin.data.shape_keys.key_blocks] == ["Basis", "Raised"]


def test_other_modifiers_stay(arm):
    skin, rig = arm
    skin.modifiers.new("Subdivision", "SUBSURF").levels = 1
    skin.modifiers["Armature"].show_in_editmode = True
    add_muscle(rig)
    bind(skin)
    assert [modifier.name for modifier in skin.modifiers] == ["Sinew", "Armature", "Subdivision"]
    bend(rig, 1.0)
    assert len(evaluated_points(skin)) > len(skin.data.vertices)


def test_two_rigs_do_not_mix():
    (skin_a, rig_a), (skin_b, rig_b) = make_arm("A"), make_arm("B")
    for skin, rig in ((skin_a, rig_a), (skin_b, rig_b)):
        add_muscle(rig, around=FLEXOR)
        bind(skin)
    bend(rig_a, 1.2)
    assert np.abs(evaluated_points(skin_b) - rest_points(skin_b)).max() <= 1e-6
    bend(rig_b, 1.2)
    assert np.abs(evaluated_points(skin_a) - evaluated_points(skin_b)).max() <= 1e-6


def test_two_meshes_on_one_rig():
    skin, rig = make_arm("A")
    skin.sinew.skin.elastic = False
    second = skin.copy()
    second.data = skin.data.copy()
    bpy.context.scene.collection.objects.link(second)
    add_muscle(rig, around=FLEXOR)
    select(rig)
    bpy.ops.sinew.bind()
    assert skin.sinew.skin.bound and second.sinew.skin.bound
    bend(rig, 1.2)
    assert np.array_equal(evaluated_points(skin), evaluated_points(second))
    assert np.linalg.norm(evaluated_points(skin) - armature_alone(skin), axis=1).max() > 5e-4


def test_a_mesh_without_weights_moves_with_the_tissues(arm):
    skin, rig = arm
    skin.vertex_groups.clear()
    add_muscle(rig)
    bind(skin)
    assert np.abs(evaluated_points(skin) - rest_points(skin)).max() <= 1e-6
    bend(rig, 1.0)
    moved = np.linalg.norm(evaluated_points(skin) - rest_points(skin), axis=1)
    assert moved.max() > 0.02


def test_bendy_bones_are_followed(arm):
    skin, rig = arm
    rig.data.bones["upper"].bbone_segments = 5
    rig.data.bones["lower"].bbone_segments = 4
    muscle = add_muscle(rig)
    muscle.scale = (0.004, 0.004, 0.01)
    skin.sinew.skin.falloff, skin.sinew.skin.motion_source = 0.06, "FULL"
    bind(skin)
    bend(rig, 1.0)
    assert np.abs(evaluated_points(skin) - points_of_the_core(skin, rig)).max() <= 1e-5


def test_the_armature_modifiers_vertex_group_is_followed(arm):
    skin, rig = arm
    mask = skin.vertex_groups.new(name="mask")
    mask.add(range(len(skin.data.vertices)), 0.6, "REPLACE")
    skin.modifiers["Armature"].vertex_group = "mask"
    add_muscle(rig, around=FLEXOR)
    bind(skin)
    bend(rig, 1.0)
    assert np.abs(evaluated_points(skin) - points_of_the_core(skin, rig)).max() <= 1e-5
