# SPDX-License-Identifier: GPL-3.0-or-later
"""Drivers of correctives: they read the bone's evaluated angle over the whole circle, without Python."""

import math

import bpy
import numpy as np
import pytest
from conftest import evaluated_points
from mathutils import Euler, Quaternion
from test_correctives import AXES, EXACT_MM, apart_mm, bake, keys_of, live_and_baked, pose, values


def test_drivers_read_a_bone_and_no_python(muscled):
    skin, rig = muscled
    bake(skin, angles="X -40..40 Y -40..40 Z 0..100")
    drivers = skin.data.shape_keys.animation_data.drivers
    assert len(drivers) == len(skin.data.shape_keys.key_blocks) - 1
    for curve in drivers:
        assert curve.driver.is_simple_expression and curve.driver.is_valid and len(curve.driver.expression) < 256
        for variable in curve.driver.variables:
            (target,) = variable.targets
            assert (variable.type, target.id, target.bone_target) == ("TRANSFORMS", rig, "lower")
            assert (target.transform_space, target.rotation_mode) == ("LOCAL_SPACE", "SWING_TWIST_Y")


@pytest.mark.parametrize("axis", ["X", "Y", "Z"])
def test_drivers_are_continuous_over_the_whole_circle(muscled, axis):
    """A key at 175 degrees, with each rotation mode and both signs of the quaternion."""
    skin, rig = muscled
    skin.sinew.skin.muscle_influence = 3.0
    bake(skin, angles=f"{axis} -175..175", tolerance=0.2)
    ends = [name for name, turns in keys_of(skin).items() if abs(turns[0][2]) == 175.0]
    assert len(ends) == 2
    bone = rig.pose.bones["lower"]
    for name in ends:
        sign = math.copysign(1.0, keys_of(skin)[name][0][2])
        last = -1.0
        for degrees in range(0, 180, 5):
            rotation = Quaternion(AXES[axis], math.radians(sign * degrees))
            found = []
            for mode, write in (
                ("QUATERNION", lambda turn=rotation: setattr(bone, "rotation_quaternion", turn)),
                ("QUATERNION", lambda turn=rotation: setattr(bone, "rotation_quaternion", -turn)),
                ("ZXY", lambda turn=rotation: setattr(bone, "rotation_euler", turn.to_euler("ZXY"))),
                (
                    "AXIS_ANGLE",
                    lambda s=sign, d=degrees: setattr(bone, "rotation_axis_angle", (math.radians(s * d), *AXES[axis])),
                ),
            ):
                bone.rotation_mode = mode
                write()
                bpy.context.view_layer.update()
                found.append(values(skin).get(name, 0.0))
            assert max(found) - min(found) < 1e-4
            assert found[0] >= last
            last = found[0]
        assert last == pytest.approx(1.0, abs=1e-4)


def test_the_angle_includes_constraints(muscled):
    skin, rig = muscled
    bake(skin)
    leader = bpy.data.objects.new("Leader", None)
    bpy.context.scene.collection.objects.link(leader)
    constraint = rig.pose.bones["lower"].constraints.new("COPY_ROTATION")
    constraint.target, constraint.owner_space, constraint.target_space = leader, "LOCAL", "WORLD"
    name, turns = max(keys_of(skin).items(), key=lambda item: item[1][0][2])
    leader.rotation_mode = "XYZ"
    leader.rotation_euler = Euler((0.0, 0.0, math.radians(turns[0][2])))
    bpy.context.view_layer.update()
    assert values(skin) == {name: pytest.approx(1.0, abs=1e-4)}
    assert apart_mm(skin) < EXACT_MM


def test_the_file_plays_without_permission_to_run_scripts(muscled, tmp_path):
    import addon_utils

    skin, rig = muscled
    bake(skin)
    name, turns = max(keys_of(skin).items(), key=lambda item: item[1][0][2])
    pose(rig, *turns)
    live, _baked = live_and_baked(skin)
    path = str(tmp_path / "arm.blend")
    bpy.ops.wm.save_as_mainfile(filepath=path)
    addon_utils.disable("bl_ext.user_default.sinew")
    try:
        bpy.ops.wm.open_mainfile(filepath=path, use_scripts=False)
        assert np.abs(evaluated_points(bpy.data.objects["Arm"]) - live).max() < 1e-5
    finally:
        addon_utils.enable("bl_ext.user_default.sinew")
