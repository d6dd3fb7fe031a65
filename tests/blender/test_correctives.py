# SPDX-License-Identifier: GPL-3.0-or-later
"""Correctives: exact at their poses, 0 at all others, within the tolerance between, for the requested joints."""

import math

import bpy
import numpy as np
import pytest
from conftest import FLEXOR, add_muscle, bind, evaluated_points, make_arm, rest_points, select, snapshot
from mathutils import Quaternion

TOLERANCE_MM = 0.5
EXACT_MM = 0.01
AXES = {"X": (1.0, 0.0, 0.0), "Y": (0.0, 1.0, 0.0), "Z": (0.0, 0.0, 1.0)}


def bake(skin, **settings):
    select(skin)
    return bpy.ops.sinew.bake_correctives(
        **{"joints": "lower", "angles": "Z 0..140", "tolerance": TOLERANCE_MM, "most_keys": 0} | settings
    )


def keys_of(skin):
    """Names of the correctives with their rotations: [(bone, axis, degrees), ...]."""
    found = {}
    for baked in skin.sinew.skin.baked_keys:
        words = baked.name.removeprefix("sinew ").split(" ")
        found[baked.name] = [(bone, turn[0], float(turn[1:])) for bone, turn in zip(words[::2], words[1::2], strict=True)]
    return found


def rotation_of(turns):
    """Several angles as one rotation: twist, then swing about an axis across the bone."""
    swing, twist = np.zeros(3), 0.0
    for axis, degrees in turns:
        if axis == "Y":
            twist += math.radians(degrees)
        else:
            swing += np.array(AXES[axis]) * math.sin(0.5 * math.radians(degrees))
    return Quaternion((math.sqrt(max(1.0 - swing @ swing, 0.0)), *swing)) @ Quaternion((0.0, 1.0, 0.0), twist)


def pose(rig, *turns):
    """Rotates bones by (bone, axis, degrees). All other bones are at rest."""
    for bone in rig.pose.bones:
        bone.rotation_mode = "QUATERNION"
        bone.rotation_quaternion = rotation_of([(axis, degrees) for name, axis, degrees in turns if name == bone.name])
    bpy.context.view_layer.update()


def live_and_baked(skin):
    points = []
    for live in (True, False):
        skin.sinew.skin.live = live
        bpy.context.view_layer.update()
        points.append(evaluated_points(skin))
    return points


def apart_mm(skin):
    live, baked = live_and_baked(skin)
    return 1000.0 * float(np.linalg.norm(live - baked, axis=1).max())


def values(skin):
    """The active keys and their evaluated values."""
    keys = skin.evaluated_get(bpy.context.evaluated_depsgraph_get()).data.shape_keys.key_blocks
    return {key.name: key.value for key in keys[1:] if key.value > 1e-4}


def test_at_its_own_pose_a_corrective_acts_alone_and_is_exact(muscled):
    skin, rig = muscled
    assert bake(skin) == {"FINISHED"}
    assert len(keys_of(skin)) >= 3 and not skin.sinew.skin.live
    for name, turns in keys_of(skin).items():
        pose(rig, *turns)
        assert values(skin) == {name: pytest.approx(1.0, abs=1e-5)}
        assert apart_mm(skin) < EXACT_MM


def test_between_its_poses_the_skin_stays_within_the_tolerance(muscled):
    skin, rig = muscled
    bake(skin)
    worst = 0.0
    for degrees in np.arange(0.0, 140.0, 3.3):
        pose(rig, ("lower", "Z", degrees))
        worst = max(worst, apart_mm(skin))
    assert 0.2 * TOLERANCE_MM < worst < 1.1 * TOLERANCE_MM


def test_a_smaller_tolerance_takes_more_keys_and_most_keys_limits_them(muscled):
    skin, _rig = muscled
    counts = []
    for settings in ({"tolerance": 2.0}, {"tolerance": 0.1}, {"tolerance": 0.1, "most_keys": 3}):
        bake(skin, **settings)
        counts.append(len(keys_of(skin)))
    assert counts[0] < counts[1] and counts[2] == 3


def test_vertices_that_do_not_move_equal_the_basis(muscled):
    skin, _rig = muscled
    bake(skin, threshold=0.05)
    keys, rest = skin.data.shape_keys.key_blocks, rest_points(skin)
    for key in keys[1:]:
        points = np.empty(3 * len(rest), np.float32)
        key.points.foreach_get("co", points)
        moved_mm = 1000.0 * np.linalg.norm(points.reshape(-1, 3) - rest, axis=1)
        assert (moved_mm[moved_mm > 0.0] > 0.049).all() and (moved_mm == 0.0).any()


def test_two_angles_at_once(muscled):
    skin, rig = muscled
    skin.sinew.skin.muscle_influence = 3.0
    bake(skin, angles="X -60..60 Z 0..100", combinations=4, tolerance=0.2)
    both = {name: turns for name, turns in keys_of(skin).items() if len(turns) == 2}
    assert both
    for name, turns in both.items():
        pose(rig, *turns)
        assert values(skin)[name] == pytest.approx(1.0, abs=1e-4)
        assert apart_mm(skin) < EXACT_MM
    for name, turns in keys_of(skin).items():
        if len(turns) == 1:
            pose(rig, *turns)
            assert values(skin) == {name: pytest.approx(1.0, abs=1e-4)}
    with_both = []
    for settings in ({"combinations": 4}, {"combinations": 0}):
        bake(skin, angles="X -60..60 Z 0..100", tolerance=0.2, **settings)
        pose(rig, ("lower", "X", 35.0), ("lower", "Z", 60.0))
        with_both.append(apart_mm(skin))
    assert with_both[0] < with_both[1]


def test_an_oblique_axis_of_the_muscles(arm):
    skin, rig = arm
    add_muscle(rig, around=FLEXOR + 0.7)
    bind(skin)
    bake(skin, angles="0..120")
    names = [baked.name for baked in skin.sinew.skin.baked_keys]
    assert names and all(name.startswith("sinew lower +") for name in names)
    from bl_ext.user_default.sinew.bake.correctives.correctives import CorrectiveBake, Settings

    settings = Settings(["lower"], False, ["0..120"], False, TOLERANCE_MM, 0.002, 0, 0, "sinew ")
    again = CorrectiveBake(rig, [skin], bpy.context.scene, settings)
    along = again.turns[0].direction
    again.cancel()
    assert abs(along[0]) > 0.3 and abs(along[2]) > 0.3 and along[1] == 0.0
    for name in names:
        degrees = float(name.rsplit("+", 1)[1])
        rig.pose.bones["lower"].rotation_mode = "QUATERNION"
        rig.pose.bones["lower"].rotation_quaternion = Quaternion(along, math.radians(degrees))
        bpy.context.view_layer.update()
        assert values(skin) == {name: pytest.approx(1.0, abs=1e-4)}
        assert apart_mm(skin) < EXACT_MM


def test_a_bone_with_a_constraint_follows_in_the_bake(arm):
    """A twist bone that copies half of its joint's rotation belongs to the keys of that joint."""
    skin, rig = arm
    select(rig)
    bpy.ops.object.mode_set(mode="EDIT")
    follower = rig.data.edit_bones.new("follower")
    follower.head, follower.tail = (0.15, 0.0, 0.0), (0.3, 0.0, 0.0)
    follower.parent = rig.data.edit_bones["upper"]
    bpy.ops.object.mode_set(mode="OBJECT")
    constraint = rig.pose.bones["follower"].constraints.new("COPY_ROTATION")
    constraint.target, constraint.subtarget, constraint.influence = rig, "lower", 0.5
    constraint.owner_space = constraint.target_space = "LOCAL"
    group = skin.vertex_groups.new(name="follower")
    group.add([index for index, point in enumerate(rest_points(skin)) if 0.2 < point[0] < 0.28], 0.5, "ADD")
    add_muscle(rig, around=FLEXOR)
    bind(skin)
    bake(skin, bones="CROSSED", joints="")
    assert {turns[0][0] for turns in keys_of(skin).values()} == {"lower"}
    for turns in keys_of(skin).values():
        pose(rig, *turns)
        assert apart_mm(skin) < EXACT_MM


def test_limits_of_the_bone_set_the_range(muscled):
    skin, rig = muscled
    bone = rig.pose.bones["lower"]
    bone.lock_ik_x, bone.lock_ik_y = True, True
    bone.use_ik_limit_z, bone.ik_min_z, bone.ik_max_z = True, math.radians(-20.0), math.radians(100.0)
    bake(skin, angles="", tolerance=0.05)
    turns = [turn for (turn,) in keys_of(skin).values()]
    assert {axis for _, axis, _ in turns} == {"Z"}
    assert max(degrees for *_, degrees in turns) == 100.0 and min(degrees for *_, degrees in turns) >= -20.0


def test_two_meshes_of_one_rig_with_scale(arm):
    """Each mesh has its own keys. The tolerance is in world space."""
    skin, rig = arm
    rig.scale = (10.0, 10.0, 10.0)
    other, other_rig = make_arm("Sleeve", radius=0.055)
    other.modifiers["Armature"].object = other.parent = rig
    bpy.data.objects.remove(other_rig)
    bpy.context.view_layer.update()
    add_muscle(rig, around=FLEXOR)
    bind(skin)
    bind(other)
    select(rig)
    bpy.ops.sinew.bake_correctives(joints="lower", angles="Z 0..140", tolerance=2.0, most_keys=0)
    for mesh in (skin, other):
        names = keys_of(mesh)
        assert names
        for degrees in (*(turns[0][2] for turns in names.values()), 33.0, 71.0):
            pose(rig, ("lower", "Z", degrees))
            assert 10.0 * apart_mm(mesh) < 2.2


@pytest.mark.parametrize(
    "settings, words",
    [
        ({"joints": "elbow"}, "no bone 'elbow'"),
        ({"joints": "upper"}, "no parent"),
        ({"angles": "0 to 90"}, "not a range of angles"),
        ({"angles": "Z 10..90"}, "rest pose"),
        ({"angles": "Z 0..200"}, "rest pose"),
        ({"angles": "Z 0..20 Z 0..30"}, "twice"),
        ({"angles": "0..20 Z 0..30"}, "twice"),
        ({"angles": "Z 0..20, X 0..30"}, "one for each"),
        ({"joints": "", "bones": "SELECTED"}, "No bones are selected"),
        ({"prefix": "p" * 60}, "longer than"),
    ],
)
def test_impossible_bakes_are_refused(muscled, settings, words):
    skin, rig = muscled
    for bone in rig.pose.bones:
        (bone if hasattr(bone, "select") else bone.bone).select = False
    before = snapshot(skin, rig)
    with pytest.raises(RuntimeError, match=words):
        bake(skin, **settings)
    assert snapshot(skin, rig) == before and skin.sinew.skin.live


def test_a_rig_that_shows_its_rest_pose_is_refused(muscled):
    skin, rig = muscled
    rig.data.pose_position = "REST"
    with pytest.raises(RuntimeError, match="rest pose"):
        bake(skin)


def test_absolute_keys_are_refused(muscled):
    skin, _rig = muscled
    skin.shape_key_add(name="Basis")
    skin.data.shape_keys.use_relative = False
    with pytest.raises(RuntimeError, match="absolute"):
        bake(skin)


def test_an_elbow_of_a_real_body_stays_on_its_side(real_body):
    skin, rig = real_body
    select(rig)
    bpy.ops.sinew.add_preset(name="limbs")
    bind(skin)
    bake(skin, joints="lowerarm01.L, lowerarm01.R", angles="0..90", tolerance=1.0, combinations=0)
    rest = rest_points(skin)
    assert len({turns[0][0] for turns in keys_of(skin).values()}) == 2
    for name, ((bone, _axis, _degrees),) in keys_of(skin).items():
        points = np.empty(3 * len(rest), np.float32)
        skin.data.shape_keys.key_blocks[name].points.foreach_get("co", points)
        moved = (points.reshape(-1, 3) != rest).any(axis=1)
        side = 1.0 if bone.endswith(".L") else -1.0
        assert moved.any() and (side * rest[moved, 0] > 0.0).all()
    for turns in keys_of(skin).values():
        pose(rig, *turns)
        assert apart_mm(skin) < EXACT_MM
