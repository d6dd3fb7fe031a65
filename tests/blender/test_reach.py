# SPDX-License-Identifier: GPL-3.0-or-later
"""Reaching in Blender: all rotation modes, locks and limits, unusual parents, and real rigs."""

import itertools
import math

import bpy
import _sinew
import numpy as np
import pytest
from bl_ext.user_default.sinew.reach import bone_limits, chains, reluctance
from bl_ext.user_default.sinew.reach import drag as drag_module
from bl_ext.user_default.sinew.reach.drag import Drag
from mathutils import Euler, Quaternion, Vector
from test_bone_recognition import KINDS, built

MODES = ("QUATERNION", "AXIS_ANGLE", "XYZ", "XZY", "YXZ", "YZX", "ZXY", "ZYX")


def make_chain(count=4, length=0.25, roll=0.0):
    """A chain of bones b0, b1, ... along X, slightly bent."""
    data = bpy.data.armatures.new("Chain")
    rig = bpy.data.objects.new("Chain", data)
    bpy.context.scene.collection.objects.link(rig)
    bpy.context.view_layer.objects.active = rig
    rig.select_set(True)
    bpy.ops.object.mode_set(mode="EDIT")
    before, at = None, Vector((0.1, 0.2, 0.3))
    for number in range(count):
        bone = data.edit_bones.new(f"b{number}")
        bone.head = at
        at = at + length * Vector((1, 0.1 * number, 0.05)).normalized()
        bone.tail = at
        bone.roll = roll + 0.3 * number
        bone.parent, bone.use_connect = before, before is not None
        before = bone
    bpy.ops.object.mode_set(mode="POSE")
    return rig


def world(rig, bone):
    bpy.context.view_layer.update()
    return rig.matrix_world @ rig.pose.bones[bone].tail


def select_bones(rig, *names):
    for bone in rig.pose.bones:
        carrier = bone if hasattr(bone, "select") else bone.bone  # 5.x, 4.5
        carrier.select = bone.name in names
    rig.data.bones.active = rig.data.bones[names[0]]


def reach(rig, bone, target, **settings):
    """Reaches with the operator; returns the evaluated distance of the bone's end from the target."""
    bpy.context.view_layer.objects.active = rig
    if rig.mode != "POSE":
        bpy.ops.object.mode_set(mode="POSE")
    assert bpy.ops.sinew.reach(bone=bone, target=target, **settings) == {"FINISHED"}
    return (world(rig, bone) - Vector(target)).length


@pytest.mark.parametrize("mode", MODES)
def test_a_reach_ends_at_its_goal_in_every_rotation_mode(mode):
    rig = make_chain()
    for number, bone in enumerate(rig.pose.bones):
        bone.rotation_mode = mode
        bone_limits.write(bone, "BALL", (0.1 * number, 0.2, -0.3))
    before = {bone.name: tuple(bone_limits.rotation_of(bone)) for bone in rig.pose.bones}
    assert reach(rig, "b3", (0.4, 0.5, 0.6), chain_length=4) < 1e-4
    assert all(tuple(bone_limits.rotation_of(bone)) != before[bone.name] for bone in rig.pose.bones)


@pytest.mark.parametrize("mode", MODES)
def test_the_written_rotation_is_the_computed_one(mode):
    rig = make_chain(1)
    bone = rig.pose.bones[0]
    bone.rotation_mode = mode
    for angles in itertools.product((-2.0, 0.4, 1.5), repeat=3):
        for parameterisation in ("BALL", "SWING_TWIST", *bone_limits.EULER_ORDERS):
            bone_limits.write(bone, parameterisation, angles)
            meant = Quaternion(_sinew.joint_rotation(parameterisation, angles))
            assert abs(bone_limits.rotation_of(bone).dot(meant)) > 1 - 1e-6
            if parameterisation in bone_limits.EULER_ORDERS:
                assert abs(Euler(angles, parameterisation).to_quaternion().dot(meant)) > 1 - 1e-6


@pytest.mark.parametrize("mode", ["QUATERNION", "AXIS_ANGLE", "XYZ"])
def test_a_long_drag_never_jumps_between_equal_rotations(mode):
    rig = make_chain()
    for bone in rig.pose.bones:
        bone.rotation_mode = mode
    bpy.context.view_layer.update()
    drag = Drag(rig, "b3", length=4, at_tail=True)
    path = bone_limits.rotation_path(rig.pose.bones[0])
    before = None
    for step in range(80):
        angle = 0.1 * step
        drag.pull(rig, Vector((0.1 + 0.5 * math.cos(angle), 0.2 + 0.5 * math.sin(angle), 0.4)), preference=1e-3)
        bpy.context.view_layer.update()
        now = np.array([tuple(getattr(bone, path)) for bone in rig.pose.bones])
        if mode == "AXIS_ANGLE":
            now = now[:, :1] * now[:, 1:]  # the axis is arbitrary if the angle is small
        if step > 1:  # the first step is long
            assert np.abs(now - before).max() < 0.8
        before = now


def odd_rig(scale=(1.2, 0.8, 1.1)):
    rig = make_chain()
    rig.location, rig.rotation_euler, rig.scale = (1, 2, 3), (0.4, -0.5, 0.6), (1.3, 1.3, 1.3)
    rig.pose.bones["b0"].scale = scale
    rig.pose.bones["b1"].rotation_mode = "XYZ"
    rig.pose.bones["b1"].rotation_euler = (0.3, 0.2, 0.1)
    rig.pose.bones["b2"].scale = (0.9, 0.9, 0.9)
    return rig


@pytest.mark.parametrize("scale", [(1.2, 1.2, 1.2), (1.2, 0.8, 1.1)])
@pytest.mark.parametrize("inherits", ["all", "no rotation", "no scale", "aligned"])
def test_scaled_and_rotated_parents_and_partial_inheritance(inherits, scale, monkeypatch):
    rig = odd_rig(scale)
    if scale[0] == scale[1] or inherits == "all":
        monkeypatch.setattr(drag_module, "MOST_PASSES", 1)  # the computed pose is the evaluated one
    bone = rig.data.bones["b2"]
    if inherits == "no rotation":
        bone.use_inherit_rotation = False
    elif inherits == "no scale":
        bone.inherit_scale = "NONE"
    elif inherits == "aligned":
        bone.inherit_scale = "ALIGNED"
    goal = world(rig, "b3").lerp(rig.matrix_world @ rig.pose.bones["b1"].head, 0.3) + Vector((0.02, 0.15, 0.12))
    # a chain that does not start at the root: the bones above it do not change
    assert reach(rig, "b3", goal, chain_length=3) < 2e-4


def test_disconnected_bones_with_a_location():
    rig = make_chain()
    bpy.ops.object.mode_set(mode="EDIT")
    rig.data.edit_bones["b2"].use_connect = False
    bpy.ops.object.mode_set(mode="POSE")
    rig.pose.bones["b2"].location = (0.05, 0.1, -0.05)
    goal = world(rig, "b3") + Vector((-0.1, 0.15, 0.12))
    assert reach(rig, "b3", goal, chain_length=4) < 1e-4


@pytest.mark.parametrize("mode", ["XYZ", "QUATERNION", "ZYX"])
def test_ik_locks_and_ik_limits_are_kept(mode):
    rig = make_chain()
    for bone in rig.pose.bones:
        bone.rotation_mode = mode
    hinge, twisted, stiff = (rig.pose.bones[name] for name in ("b1", "b2", "b0"))
    hinge.lock_ik_y = hinge.lock_ik_z = True
    hinge.use_ik_limit_x, hinge.ik_min_x, hinge.ik_max_x = True, -0.2, 0.5
    twisted.use_ik_limit_x, twisted.ik_min_x, twisted.ik_max_x = True, -0.4, 0.4
    twisted.use_ik_limit_z, twisted.ik_min_z, twisted.ik_max_z = True, -0.1, 0.3
    stiff.ik_stiffness_x = 0.5
    for goal in ((0.4, 0.5, 0.6), (-0.3, 0.2, 0.1), (0.3, -0.2, 0.9), (3, 3, 3)):
        reach(rig, "b3", goal, chain_length=4)
        x, y, z = _sinew.joint_angles("SWING_TWIST", tuple(bone_limits.rotation_of(hinge)), (0, 0, 0))
        assert -0.2 - 1e-6 <= x <= 0.5 + 1e-6 and abs(y) < 1e-6 and abs(z) < 1e-6
        x, _, z = _sinew.joint_angles("SWING_TWIST", tuple(bone_limits.rotation_of(twisted)), (0, 0, 0))
        assert abs(x) <= 0.4 + 1e-6 and -0.1 - 1e-6 <= z <= 0.3 + 1e-6
    assert bone_limits.joint_of(stiff).eagerness < bone_limits.joint_of(twisted).eagerness


def test_locked_euler_channels_keep_their_value_to_the_bit():
    rig = make_chain()
    bone = rig.pose.bones["b1"]
    bone.rotation_mode = "YZX"
    bone.rotation_euler = (0.1, 0.7, -0.2)
    bone.lock_rotation = (False, True, False)
    before = bone.rotation_euler.y
    reach(rig, "b3", (0.4, 0.5, 0.6), chain_length=4)
    assert bone.rotation_euler.y == before
    assert bone.rotation_euler.x != pytest.approx(0.1)


@pytest.mark.parametrize("mode", ["XYZ", "QUATERNION"])
def test_limit_rotation_constraints_have_nothing_to_correct(mode):
    rig = make_chain()
    for bone in rig.pose.bones:
        bone.rotation_mode = mode
        limit = bone.constraints.new("LIMIT_ROTATION")
        limit.owner_space = "LOCAL"
        limit.use_limit_x = limit.use_limit_y = limit.use_limit_z = True
        limit.min_x, limit.max_x, limit.min_y, limit.max_y, limit.min_z, limit.max_z = -0.3, 0.6, -0.1, 0.1, -0.5, 0.2
    for goal in ((0.4, 0.5, 0.6), (0.3, -0.4, 0.5), (3, 3, 3)):
        reach(rig, "b3", goal, chain_length=4)
        limited = {bone.name: bone.matrix.copy() for bone in rig.pose.bones}
        for bone in rig.pose.bones:
            bone.constraints[0].mute = True
        bpy.context.view_layer.update()
        for bone in rig.pose.bones:
            assert np.abs(np.array(bone.matrix) - np.array(limited[bone.name])).max() < 1e-5
            bone.constraints[0].mute = False


def test_other_constraints_are_left_alone():
    rig = make_chain()
    bone = rig.pose.bones["b1"]
    constraint = bone.constraints.new("DAMPED_TRACK")
    constraint.target = bpy.data.objects.new("Seen", None)
    bpy.context.scene.collection.objects.link(constraint.target)
    solved = rig.pose.bones["b0"].constraints.new("IK")
    solved.target, solved.influence = constraint.target, 0.0  # it does nothing, so its bone is free
    copied = rig.pose.bones["b2"].constraints.new("COPY_ROTATION")
    copied.target, copied.subtarget, copied.influence = rig, "b0", 0.3
    before = tuple(bone_limits.rotation_of(bone)), tuple(bone_limits.rotation_of(rig.pose.bones["b2"]))
    reach(rig, "b3", (0.5, 0.5, 0.5), chain_length=4)
    assert before == (tuple(bone_limits.rotation_of(bone)), tuple(bone_limits.rotation_of(rig.pose.bones["b2"])))
    assert bone_limits.rotation_of(rig.pose.bones["b0"]).angle > 0.01
    assert (constraint.influence, copied.influence) == (1.0, pytest.approx(0.3))


def test_a_chain_that_cannot_rotate_is_named():
    rig = make_chain()
    for bone in rig.pose.bones:
        bone.lock_rotation = (True, True, True)
        bone.rotation_mode = "XYZ"
    with pytest.raises(RuntimeError, match="none of the bones b1, b2, b3 can rotate"):
        bpy.ops.sinew.reach(bone="b3", target=(0, 0, 0))
    with pytest.raises(RuntimeError, match="has no bone 'hand'"):
        bpy.ops.sinew.reach(bone="hand", target=(0, 0, 0))
    rig.data.pose_position = "REST"
    with pytest.raises(RuntimeError, match="shows its rest pose"):
        bpy.ops.sinew.reach(bone="b3", target=(0, 0, 0))


def test_cancelling_restores_every_bit():
    rig = odd_rig()
    bpy.context.view_layer.update()

    def bits():
        bones = rig.pose.bones
        return [(*bone.rotation_euler, *bone.rotation_quaternion, *bone.rotation_axis_angle) for bone in bones]

    before = bits()
    drag = Drag(rig, "b3", length=4, at_tail=True)
    drag.pull(rig, Vector((1.2, 2.4, 3.1)), preference=1e-3)
    assert bits() != before
    drag.put_back(rig)
    assert bits() == before


def test_the_same_drag_gives_the_same_bits():
    def dragged():
        bpy.ops.wm.read_factory_settings(use_empty=True)
        rig = make_chain()
        reach(rig, "b3", (0.4, 0.5, 0.6), chain_length=4)
        return [tuple(bone.rotation_quaternion) for bone in rig.pose.bones]

    assert dragged() == dragged()


def test_the_orientation_can_be_kept():
    rig = make_chain(6)
    bpy.context.view_layer.update()
    before = rig.pose.bones["b5"].matrix.to_quaternion()
    goal = world(rig, "b5") + Vector((-0.3, 0.2, 0.1))
    assert reach(rig, "b5", goal, chain_length=6, keep_orientation=True) < 1e-3
    assert abs(before.dot(rig.pose.bones["b5"].matrix.to_quaternion())) > 1 - 1e-5


def test_the_rest_pose_can_be_preferred():
    rig = make_chain(6)
    for bone in rig.pose.bones:
        bone_limits.write(bone, "BALL", (0.5, 0.0, 0.0))
    goal = world(rig, "b5") + Vector((0.02, 0.0, 0.0))

    def bend():
        return sum(bone_limits.rotation_of(bone).angle for bone in rig.pose.bones)

    assert reach(rig, "b5", goal, chain_length=6) < 1e-4
    as_it_was = bend()
    assert reach(rig, "b5", goal, chain_length=6, prefer="REST", preference=0.1) < 1e-4
    assert bend() < 0.9 * as_it_was


def test_eager_bones_rotate_more():
    def turned(multiplier):
        bpy.ops.wm.read_factory_settings(use_empty=True)
        rig = make_chain()
        rig.pose.bones["b0"].sinew.eagerness = multiplier
        reach(rig, "b3", (0.5, 0.6, 0.5), chain_length=4)
        return bone_limits.rotation_of(rig.pose.bones["b0"]).angle

    assert turned(0.1) < 0.9 * turned(1.0) < turned(2.5)


@pytest.mark.parametrize("kind", ["Mixamo", "Unreal mannequin"])
def test_chains_go_from_the_pelvis_to_hands_and_feet(kind):
    rig = built(*KINDS[kind])
    bpy.ops.object.mode_set(mode="OBJECT")
    ends = chains.ends_of(rig)
    assert len(ends) == 4
    bpy.ops.object.mode_set(mode="POSE")
    for (role, _side), bone in ends.items():
        chain = chains.chain_of(rig, bone)
        assert chain[-1] == bone and len(chain) >= (3 if role == "foot" else 6)
        assert not any("ips" in name or "pelvis" in name for name in chain)
        goal = world(rig, bone) + Vector((0.05, -0.25, 0.1))
        assert reach(rig, bone, goal, end="TAIL") < 2e-4


def test_a_rigify_metarig_reaches(rigify):
    bpy.ops.object.armature_human_metarig_add()
    rig = bpy.context.object
    chain = chains.chain_of(rig, "hand.L")
    assert chain == ["spine.001", "spine.002", "spine.003", "shoulder.L", "upper_arm.L", "forearm.L", "hand.L"]
    assert chains.chain_of(rig, "foot.R") == ["thigh.R", "shin.R", "foot.R"]
    assert reach(rig, "hand.L", (0.1, -0.2, 1.65)) < 2e-4
    assert reach(rig, "foot.R", (-0.15, -0.35, 0.3)) < 2e-4


def test_a_real_body_reaches_with_its_skin(real_body):
    skin, rig = real_body
    hand, foot = (chains.ends_of(rig)[end] for end in (("hand", "L"), ("foot", "R")))
    assert reach(rig, hand, world(rig, hand) + Vector((-0.1, -0.25, 0.2))) < 2e-4
    assert reach(rig, foot, world(rig, foot) + Vector((0.0, -0.3, 0.25))) < 2e-4


def test_rotating_and_resetting_joints():
    rig = make_chain()
    b1, b2 = rig.pose.bones["b1"], rig.pose.bones["b2"]
    select_bones(rig, *rig.pose.bones.keys())
    b1.sinew.eagerness = 2.0
    b2.lock_ik_x = True
    rig.pose.bones["b3"].use_ik_limit_x = True
    rig.pose.bones["b3"].ik_max_x = 0.1
    bpy.ops.sinew.rotate_joint(axis="X", angle=0.3)
    assert bone_limits.rotation_of(rig.pose.bones["b0"]).angle == pytest.approx(0.3, abs=1e-5)
    assert bone_limits.rotation_of(b1).angle == pytest.approx(0.6, abs=1e-5)
    assert bone_limits.rotation_of(b2).angle == pytest.approx(0.0, abs=1e-6)
    assert bone_limits.rotation_of(rig.pose.bones["b3"]).angle == pytest.approx(0.1, abs=1e-5)
    b2.rotation_quaternion = Euler((0.4, 0, 0)).to_quaternion()
    bpy.ops.sinew.rest_pose()
    angles = [bone_limits.rotation_of(bone).angle for bone in rig.pose.bones]
    assert angles == pytest.approx([0, 0, 0.4, 0], abs=1e-6)


def test_auto_keying_keys_only_rotated_bones():
    rig = make_chain()
    reach(rig, "b3", (0.4, 0.5, 0.6), chain_length=2)
    assert rig.animation_data is None
    bpy.context.scene.tool_settings.use_keyframe_insert_auto = True
    reach(rig, "b3", (0.5, 0.4, 0.6), chain_length=2)
    paths = {curve.data_path for curve in curves_of(rig)}
    assert paths == {f'pose.bones["{name}"].rotation_quaternion' for name in ("b2", "b3")}


def curves_of(rig):
    action = rig.animation_data.action
    return [curve for layer in action.layers for strip in layer.strips for bag in strip.channelbags for curve in bag.fcurves]


@pytest.mark.usefixtures("rigify")
def test_a_hand_to_the_head_bends_the_arm_more_than_the_spine():
    bpy.ops.object.armature_human_metarig_add()
    rig = bpy.context.object
    bpy.ops.object.mode_set(mode="POSE")
    goal = rig.matrix_world @ rig.pose.bones["spine.006"].tail
    assert reach(rig, "forearm.L", goal + Vector((0.05, -0.1, 0.0))) < 1e-3
    turned = {bone.name: bone.matrix_basis.to_quaternion().angle for bone in rig.pose.bones}
    spine = sum(angle for name, angle in turned.items() if name.startswith("spine"))
    assert spine < 0.5 * (turned["forearm.L"] + turned["upper_arm.L"]), turned


def test_a_chain_without_branches_is_not_reluctant():
    rig = make_chain()
    names = [bone.name for bone in rig.pose.bones]
    assert list(reluctance.factors(rig, names)) == [1.0] * 4
    bpy.ops.object.mode_set(mode="EDIT")
    aside = rig.data.edit_bones.new("aside")
    aside.head, aside.tail = rig.data.edit_bones["b1"].tail, rig.data.edit_bones["b1"].tail + Vector((0.0, 0.25, 0.0))
    aside.parent = rig.data.edit_bones["b1"]
    bpy.ops.object.mode_set(mode="POSE")
    factors = reluctance.factors(rig, names)
    # b1 also moves as much again as one of its three: 3 of 4 parts, and b0 4 of 5
    assert list(factors) == pytest.approx([(4 / 5) ** 2, (3 / 4) ** 2, 1.0, 1.0], rel=1e-4)
