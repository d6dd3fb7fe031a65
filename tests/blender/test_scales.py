# SPDX-License-Identifier: GPL-3.0-or-later
"""Scaled rigs and parents: in the rig's own axes, the live skin and every bake are what they are without a scale.

test_export_whole.py has the same for export copies and files, test_garments.py for garments.
"""

import bpy
import numpy as np
import pytest
from conftest import FLEXOR, add_muscle, bend, bind, evaluated_points, make_arm, select

SCALES = {
    "even": (2.0, 2.0, 2.0),
    "uneven": (1.0, 1.4, 0.7),
    "mirrored": (-1.0, 1.0, 1.0),
    "turned inside out": (-1.0, -1.0, -1.0),
    "hundredth": (0.01, 0.01, 0.01),
}
NEAR_M = 2e-6  # of an arm of 0.6 m
LOCATION = (0.1, -0.2, 0.3)


def muscled_arm(scaled="", scale=(1.0, 1.0, 1.0)):
    """(mesh, rig): an arm whose rig, or whose rig's parent, is scaled and rotated, bound and bending over ten frames."""
    skin, rig = make_arm()
    if scaled:
        moved = rig
        if scaled == "parent":
            moved = rig.parent = bpy.data.objects.new("Parent", None)
            bpy.context.scene.collection.objects.link(moved)
        moved.scale, moved.rotation_euler, moved.location = scale, (0.3, 0.2, 0.5), LOCATION
    bpy.context.view_layer.update()
    add_muscle(rig, around=FLEXOR)
    bind(skin)
    bend(rig, 0.0)
    for frame, angle in ((1, 0.0), (10, 1.2)):
        bend(rig, angle)
        rig.pose.bones["lower"].keyframe_insert("rotation_euler", frame=frame)
    bpy.context.scene.frame_start, bpy.context.scene.frame_end = 1, 10
    return skin, rig


def shape_keys(rig, tolerance):
    select(rig)
    bpy.ops.sinew.bake_shape_keys(frame_start=1, frame_end=10, tolerance=tolerance)


def correctives(rig, tolerance):
    select(rig)
    bpy.ops.sinew.bake_correctives(bones="ALL", angles="Z 0..70", tolerance=tolerance)


@pytest.fixture(scope="module")
def unscaled():
    bpy.ops.wm.read_factory_settings(use_empty=True)
    skin, _rig = muscled_arm()
    bpy.context.scene.frame_set(10)
    return evaluated_points(skin)


@pytest.mark.parametrize("scaled", ["rig", "parent"])
@pytest.mark.parametrize("scale", SCALES)
@pytest.mark.parametrize("bake", [shape_keys, correctives])
def test_a_scale_changes_nothing_in_the_axes_of_the_rig(unscaled, bake, scale, scaled):
    """The live skin has the same points, and a bake is within its tolerance, which is in mm of the world."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    skin, rig = muscled_arm(scaled, SCALES[scale])
    bpy.context.scene.frame_set(10)
    live = evaluated_points(skin)
    # an object's location is rounded in the world, and divided by the scale in the rig's axes
    rounding_m = np.linalg.norm(LOCATION) * np.finfo(np.float32).eps / np.abs(SCALES[scale]).min()
    assert np.abs(live - unscaled).max() < NEAR_M + rounding_m
    tolerance = float(np.abs(SCALES[scale]).mean())
    bake(rig, tolerance)
    assert not skin.sinew.skin.live
    bpy.context.scene.frame_set(10)
    to_world = np.array(skin.matrix_world)[:3, :3]
    errors_mm = 1e3 * np.linalg.norm((evaluated_points(skin) - live) @ to_world.T, axis=1)
    assert errors_mm.max() < 1.1 * tolerance
