# SPDX-License-Identifier: GPL-3.0-or-later
"""X-mirror: editing a tissue edits its twin on the other side."""

import bpy
import pytest
from bl_ext.user_default.sinew.scene import tissue_empty
from conftest import select
from mathutils import Matrix, Vector
from test_mirror import assert_mirrored, muscle, twins

ACROSS = Matrix.Diagonal((-1.0, 1.0, 1.0))  # from one side of the body to the other


def pair():
    rig = twins()
    left, right = muscle(rig, "Deltoid.L"), muscle(rig, "Deltoid.R", insertion="arm.R")
    muscle(rig, "Sternum", insertion="spine")
    select(left)
    bpy.ops.sinew.mirror()
    select(left)
    bpy.context.view_layer.update()
    return rig, left, right


@pytest.mark.parametrize("switch", ["mirror_x", "use_mirror_x"])
def test_x_mirror_moves_the_twin(switch):
    rig, left, right = pair()
    setattr(rig.sinew.rig if switch == "mirror_x" else rig.data, switch, True)
    bpy.context.view_layer.update()
    for _ in range(3):
        left.location += Vector((0.02, 0.01, -0.03))
        left.rotation_euler.z += 0.3
        left.scale.x *= 1.2
        bpy.context.view_layer.update()
        assert_mirrored(rig, left, right)
    right.location.y += 0.05
    bpy.context.view_layer.update()
    assert_mirrored(rig, left, right)


def test_x_mirror_is_off_by_default_and_in_a_pose():
    rig, left, right = pair()
    before = right.location.copy()
    left.location.x += 0.05
    bpy.context.view_layer.update()
    assert right.location == before
    rig.sinew.rig.mirror_x = True
    rig.pose.bones["arm.L"].rotation_quaternion = (0.9, 0.1, 0, 0)
    bpy.context.view_layer.update()
    left.location.x += 0.05
    bpy.context.view_layer.update()
    assert right.location == before
    rig.data.pose_position = "REST"
    bpy.context.view_layer.update()
    left.location.x += 0.05
    bpy.context.view_layer.update()
    assert right.location != before
    assert_mirrored(rig, left, right)


def test_x_mirror_does_not_change_a_pair_that_moves_together():
    rig, left, right = pair()
    rig.sinew.rig.mirror_x = True
    bpy.context.view_layer.update()
    left.location.z += 0.1
    right.location.z += 0.2
    wanted = right.location.copy()
    bpy.context.view_layer.update()
    assert right.location == wanted
    rig.location.x += 1.0
    bpy.context.view_layer.update()
    assert right.location == wanted


def test_x_mirror_does_not_change_a_pair_without_edits():
    """Posing one side and resetting it moves its tissues, but does not edit them; nor do added and removed objects."""
    rig, left, right = pair()
    right.location.y += 0.2
    bpy.context.view_layer.update()
    rig.sinew.rig.mirror_x = True
    bpy.context.view_layer.update()
    wanted = left.location.copy(), right.location.copy()
    bone = rig.pose.bones["arm.L"]
    for turn in ((0.9, 0.1, 0, 0), (1, 0, 0, 0)):
        bone.rotation_quaternion = turn
        bpy.context.view_layer.update()
    between = bpy.data.objects.new("Deltoid.P", None)
    bpy.context.scene.collection.objects.link(between)
    bpy.context.view_layer.update()
    muscle(rig, "Deltoid.O", insertion="spine")
    bpy.context.view_layer.update()
    bpy.data.objects.remove(between)
    rig.location.x += 1.0
    bpy.context.view_layer.update()
    assert (left.location, right.location) == wanted


def test_x_mirror_is_undone_with_its_edit():
    rig, left, right = pair()
    rig.sinew.rig.mirror_x = True
    bpy.context.view_layer.update()
    bpy.ops.ed.undo_push(message="mirror on")
    before = tuple(left.location), tuple(right.location)
    left.location.x += 0.05
    bpy.context.view_layer.update()
    bpy.ops.ed.undo_push(message="move")
    after = tuple(left.location), tuple(right.location)
    assert before[1] != after[1]
    bpy.ops.ed.undo()
    assert (tuple(bpy.data.objects["Deltoid.L"].location), tuple(bpy.data.objects["Deltoid.R"].location)) == before
    bpy.ops.ed.redo()
    assert (tuple(bpy.data.objects["Deltoid.L"].location), tuple(bpy.data.objects["Deltoid.R"].location)) == after


def test_x_mirror_mirrors_settings_too():
    rig, left, right = pair()
    rig.sinew.rig.mirror_x = True
    bpy.context.view_layer.update()
    left.sinew.tissue.origin_tendon = 0.07
    bpy.context.view_layer.update()
    assert right.sinew.tissue.origin_tendon == pytest.approx(0.07, abs=1e-6)


def test_x_mirror_follows_a_dragged_via_point(human):
    human.sinew.rig.mirror_x = True
    via = tissue_empty.vias_of(bpy.data.objects["Sartorius.L"])[0]
    via.location.z += 0.01
    bpy.context.view_layer.update()
    (_, own), (_, twin) = (
        tissue_empty.read(bpy.data.objects[name], human).via_points[0] for name in ("Sartorius.L", "Sartorius.R")
    )
    assert (ACROSS @ own - twin).length < 1e-5
