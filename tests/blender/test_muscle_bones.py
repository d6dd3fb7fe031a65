# SPDX-License-Identifier: GPL-3.0-or-later
"""Muscle bones: they follow the bellies by constraints on an export copy, and the character does not change."""

import bpy
import numpy as np
import pytest
from bl_ext.user_default.sinew.live import session
from conftest import FLEXOR, add_muscle, bend, bind, evaluated_points, points_over, select, snapshot

# name, angle around the arm, tendons, volume keeping
MUSCLES = (
    ("Flexor.L", FLEXOR, (0.05, 0.01), 1.0),
    ("Side", 0.3, (0.0, 0.0), 0.6),
    ("Back", 1.7, (0.0, 0.04), 1.2),
)


@pytest.fixture
def waving(arm):
    """(mesh, rig): a bound arm with three muscles that bends by 80 degrees over frames 1 to 12, about two axes."""
    skin, rig = arm
    for name, around, tendons, keeping in MUSCLES:
        add_muscle(rig, around=around, name=name)
        muscle = bpy.data.objects[name]
        muscle.sinew.tissue.origin_tendon, muscle.sinew.tissue.insertion_tendon = tendons
        muscle.sinew.tissue.volume_keeping = keeping
    bone = rig.pose.bones["lower"]
    bone.rotation_mode = "XYZ"
    for frame, angles in ((1, (0.0, 0.0, 0.0)), (12, (0.3, 0.4, 1.4))):
        bone.rotation_euler = angles
        bone.keyframe_insert("rotation_euler", frame=frame)
    bind(skin)
    bpy.context.scene.frame_set(1)
    return skin, rig


def bake_bones(rig, **settings):
    select(rig)
    assert bpy.ops.sinew.bake_bones(**{"frame_start": 1, "frame_end": 12} | settings) == {"FINISHED"}
    return copies_of(rig)


def copies_of(rig):
    """Shows the export copy; returns its mesh and rig."""
    collection = rig.sinew.rig.export_copy
    bpy.context.view_layer.layer_collection.children[collection.name].exclude = False
    bpy.context.view_layer.update()
    of_type = {found.type: found for found in collection.objects}
    return of_type["MESH"], of_type["ARMATURE"]


def bellies(rig, tense=True):
    """Name, posed matrix (unit sphere to belly, armature space) and rest semi-axes of each muscle, from the core."""
    state = session.cached_rig(rig)
    posed = np.empty_like(state.posed)
    state.musculature.pose(state.pose, state.tension if tense else np.zeros_like(state.tension), posed)
    names = sorted(found.name for found in bpy.data.objects if found.type == "EMPTY" and found.sinew.tissue.kind == "MUSCLE")
    return zip(names, posed.transpose(0, 2, 1), strict=True)


def assert_bones_are_bellies(rig, rig_copy, most=1e-5):
    """Each muscle's bone has the scale (relative), axes and position (m) of its belly."""
    rig.data.pose_position = "REST"
    bpy.context.view_layer.update()
    rest = {name: np.linalg.norm(matrix[:3, :3], axis=0) for name, matrix in bellies(rig, tense=False)}
    rig.data.pose_position = "POSE"
    bpy.context.view_layer.update()
    for name, belly in bellies(rig):
        bone = np.array(rig_copy.pose.bones[f"muscle {name}"].matrix)
        x, y, z = (belly[:3, axis] / rest[name][axis] for axis in range(3))
        wanted = np.stack((x, z, -y, belly[:3, 3]), axis=1)
        assert np.abs(bone[:3] - wanted).max() < most, name


@pytest.mark.parametrize("scale", [1.0, 0.01])
def test_constraints_follow_the_bellies(waving, scale):
    _skin, rig = waving
    rig.scale = (scale,) * 3
    bpy.context.view_layer.update()
    _mesh, rig_copy = bake_bones(rig)
    for frame in (1, 5, 8, 12):
        bpy.context.scene.frame_set(frame)
        assert_bones_are_bellies(rig, rig_copy)


def test_a_pose_that_was_not_baked_follows_the_bellies(waving):
    _skin, rig = waving
    _mesh, rig_copy = bake_bones(rig)
    for found in (rig, rig_copy):
        found.animation_data.action = None
        found.pose.bones["upper"].rotation_mode = "XYZ"
        found.pose.bones["upper"].rotation_euler = (0.5, -0.2, 0.9)
        bend(found, -0.7)
    assert_bones_are_bellies(rig, rig_copy)


@pytest.mark.parametrize("keyed", [False, True])
def test_tension_and_curved_muscles_are_keyed(waving, keyed):
    _skin, rig = waving
    flexor, side = bpy.data.objects["Flexor.L"], bpy.data.objects["Side"]
    for frame, tension in ((1, 0.0), (12, 1.0)):
        flexor.sinew.tissue.tension = tension
        flexor.sinew.tissue.keyframe_insert("tension", frame=frame)
    side.sinew.tissue.tension = 0.5
    select(bpy.data.objects["Back"])
    bpy.ops.sinew.add_via_point()
    _mesh, rig_copy = bake_bones(rig, keyed=keyed)
    assert not rig_copy.pose.bones["muscle Back"].constraints
    assert bool(rig_copy.pose.bones["muscle Side"].constraints) != keyed
    for frame in (1, 7, 12):
        bpy.context.scene.frame_set(frame)
        assert_bones_are_bellies(rig, rig_copy)
    assert rig.animation_data.action != rig_copy.animation_data.action


@pytest.mark.parametrize("influences", [4, 8])
def test_weights_are_few_and_sum_to_one(waving, influences):
    skin, rig = waving
    mesh, rig_copy = bake_bones(rig, influences=str(influences))
    deforming = {group.index for group in mesh.vertex_groups if rig_copy.data.bones[group.name].use_deform}
    rows = [[own.weight for own in vertex.groups if own.group in deforming] for vertex in mesh.data.vertices]
    assert max(map(len, rows)) <= influences
    assert np.abs(np.array(list(map(sum, rows))) - 1.0).max() < 1e-5
    assert any(group.name == "muscle Flexor.L" for group in mesh.vertex_groups)


def test_fitted_weights_are_closer_than_the_armature_alone(waving):
    skin, rig = waving
    live = points_over(skin, range(1, 13))
    skin.modifiers["Sinew"].show_viewport = False
    bare = points_over(skin, range(1, 13))
    skin.modifiers["Sinew"].show_viewport = True
    mesh, _rig_copy = bake_bones(rig)
    engine = points_over(mesh, range(1, 13))
    assert np.linalg.norm(engine - live, axis=2).mean() < 0.7 * np.linalg.norm(bare - live, axis=2).mean()


@pytest.mark.parametrize("kind", ["frames", "correctives"])
def test_baked_keys_fit_the_copy(waving, kind):
    """On the copy, keys and muscle bones do not add up: together they equal the live skin at exact keys."""
    skin, rig = waving
    select(skin)
    if kind == "frames":
        bpy.ops.sinew.bake_shape_keys(frame_start=1, frame_end=12, step=1, prefix="sinew_", tolerance=0.0)
        frames = range(1, 13)
    else:
        bone = rig.pose.bones["lower"]
        rig.animation_data.action = None
        for frame, angle in ((1, 0.0), (12, 1.5)):
            bone.rotation_euler = (0.0, 0.0, angle)
            bone.keyframe_insert("rotation_euler", frame=frame)
        bpy.ops.sinew.bake_correctives(joints="lower", angles="Z 0..85.943669", tolerance=0.2)
        frames = (1, 12)
    skin.sinew.skin.live = True
    live = points_over(skin, frames)
    mesh, _rig_copy = bake_bones(rig)
    assert any(group.name.startswith("muscle") for group in mesh.vertex_groups)
    assert np.linalg.norm(points_over(mesh, frames) - live, axis=2).max() < 1e-5
    assert all(not key.mute for key in mesh.data.shape_keys.key_blocks)
    drivers = mesh.data.shape_keys.animation_data.drivers
    assert {target.id for curve in drivers for variable in curve.driver.variables for target in variable.targets} <= {
        _rig_copy
    }


def view_of(context):
    scene, active = context.scene, context.view_layer.objects.active
    return (
        scene.frame_current, active.name, active.mode, sorted(found.name for found in context.selected_objects),
    )  # fmt: skip


def test_the_character_does_not_change(waving):
    skin, rig = waving
    skin.sinew.skin.live = False
    select(rig, skin)
    bpy.ops.object.mode_set(mode="POSE")
    bpy.context.scene.frame_set(5)
    before = view_of(bpy.context), snapshot_of_character(skin, rig), evaluated_points(skin)
    bpy.ops.sinew.bake_bones(frame_start=1, frame_end=12)
    after = view_of(bpy.context), snapshot_of_character(skin, rig), evaluated_points(skin)
    assert after[:2] == before[:2] and np.array_equal(after[2], before[2])
    assert not skin.sinew.skin.live


def snapshot_of_character(skin, rig):
    found = snapshot(skin, rig)
    for shared in ("objects", "collections", "actions", "custom"):
        del found[shared]
    return found | {"bones": rig.data.bones.keys(), "action": rig.animation_data.action.name}


def test_a_new_bake_replaces_the_old_and_remove_takes_it_away(waving):
    skin, rig = waving
    bpy.data.objects["Flexor.L"].sinew.tissue.tension = 0.3
    before = sorted(found.name for found in bpy.data.objects), sorted(found.name for found in bpy.data.actions)
    bake_bones(rig, keyed=True)
    mesh, rig_copy = bake_bones(rig, keyed=True)
    assert (mesh.name, rig_copy.name, mesh.users_collection[0].name) == ("Arm Export", "Arm Rig Export", "Arm Rig Export")
    assert len(bpy.data.objects) == len(before[0]) + 2 and len(bpy.data.armatures) == 2 == len(bpy.data.meshes)
    select(rig)
    bpy.ops.sinew.remove()
    assert len(bpy.data.armatures) == 1 == len(bpy.data.meshes)
    assert "Arm Rig Export" not in bpy.data.collections
    assert sorted(found.name for found in bpy.data.actions) == before[1]


def test_a_point_cache_stays_with_the_character(waving, tmp_path):
    skin, rig = waving
    select(skin)
    bpy.ops.sinew.bake_cache(frame_start=1, frame_end=12, folder=str(tmp_path))
    mesh, _rig_copy = bake_bones(rig)
    assert [modifier.type for modifier in mesh.modifiers] == ["ARMATURE"]
    assert "MESH_CACHE" in [modifier.type for modifier in skin.modifiers]


def test_remove_can_keep_the_copy(waving):
    skin, rig = waving
    mesh, rig_copy = bake_bones(rig)
    before = points_over(mesh, range(1, 13))
    select(rig)
    bpy.ops.sinew.remove(keep_baked=True)
    assert np.array_equal(points_over(mesh, range(1, 13)), before)
    assert not mesh.keys() and not rig_copy.keys() and not rig.is_property_set("sinew")


def test_a_cancelled_bake_of_bones_leaves_nothing(waving):
    from bl_ext.user_default.sinew.export.bone_bake import BoneBake, Settings

    skin, rig = waving
    select(rig)
    before = view_of(bpy.context), sorted(found.name for found in bpy.data.objects), skin.sinew.skin.live
    steps = BoneBake(bpy.context, rig, [skin], Settings(1, 12, 1, 4, False, "FITTED")).steps()
    for _ in range(8):
        next(steps)
    steps.close()
    assert (view_of(bpy.context), sorted(found.name for found in bpy.data.objects), skin.sinew.skin.live) == before
    assert len(bpy.data.armatures) == 1 and rig.sinew.rig.export_copy is None


@pytest.mark.parametrize(
    ("spoil", "message"),
    [
        (lambda skin, rig: bpy.ops.sinew.unbind(), "not bound"),
        (lambda skin, rig: setattr(rig.data, "pose_position", "REST"), "rest pose"),
        (lambda skin, rig: setattr(skin.modifiers["Armature"], "vertex_group", "upper"), "vertex group"),
        (
            lambda skin, rig: [bpy.data.objects.remove(found) for found in list(rig.children) if found.type == "EMPTY"],
            "muscle",
        ),
    ],
)
def test_impossible_bakes_of_bones_say_why(waving, spoil, message):
    skin, rig = waving
    select(skin)
    spoil(skin, rig)
    bpy.context.view_layer.update()
    count = len(bpy.data.objects)
    with pytest.raises(RuntimeError, match=message):
        bpy.ops.sinew.bake_bones(frame_start=1, frame_end=12)
    assert len(bpy.data.objects) == count


def test_frames_in_the_wrong_order_are_refused(waving):
    skin, rig = waving
    select(rig)
    with pytest.raises(RuntimeError, match="before the first"):
        bpy.ops.sinew.bake_bones(frame_start=12, frame_end=1)
