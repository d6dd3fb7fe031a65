# SPDX-License-Identifier: GPL-3.0-or-later
"""Trying Sinew: a character from nothing, a range of motion, and a report of what is wrong."""

import logging
import math

import bpy
import numpy as np
import pytest
from bl_ext.user_default.sinew.files import log
from bl_ext.user_default.sinew.live import session
from bl_ext.user_default.sinew.operators import range_of_motion, whats_wrong
from bl_ext.user_default.sinew.scene import characters
from conftest import evaluated_points, lifts, select


def test_an_empty_file_gets_a_human_that_flexes(empty_file):
    bpy.ops.sinew.example_character()
    rig = bpy.context.object
    assert rig.type == "ARMATURE" and rig.select_get()
    character = characters.character_of(rig)
    assert len(character.tissues) > 150 and len(character.skins) == 1
    skin = character.skins[0].find()
    assert 1.6 < skin.dimensions.z < 2.0
    assert session.cached_rig(rig).problems == {} and not session.reason(skin)
    before = evaluated_points(skin)
    bone = rig.pose.bones["forearm.L"]
    bone.rotation_mode = "XYZ"
    bone.rotation_euler.x = 1.4
    bpy.context.view_layer.update()
    moved = np.linalg.norm(evaluated_points(skin) - before, axis=1)
    assert moved.max() > 0.1 and lifts(skin).max() > 0.002
    assert moved[before[:, 0] < 0.0].max() < 0.01  # the other side rests


def test_the_example_is_one_step_back(empty_file):
    bpy.ops.ed.undo_push(message="before")
    bpy.ops.sinew.example_character()
    bpy.ops.ed.undo_push(message="example")
    bpy.ops.ed.undo()
    assert len(bpy.data.objects) == 0


def angles_of(rig, bone):
    """The rotation of a bone from the rest pose in each frame of the scene, in radians."""
    scene = bpy.context.scene
    found = []
    for frame in range(scene.frame_start, scene.frame_end + 1):
        scene.frame_set(frame)
        found.append(rig.pose.bones[bone].matrix_basis.to_quaternion().angle)
    return np.array(found)


@pytest.mark.parametrize("mode", ["QUATERNION", "XYZ", "AXIS_ANGLE"])
def test_the_range_of_motion_rotates_each_joint_and_comes_back(muscled, mode):
    skin, rig = muscled
    rig.pose.bones["lower"].rotation_mode = mode
    select(rig)
    bpy.ops.sinew.range_of_motion(frames=4, fraction=0.5)
    angles = angles_of(rig, "lower")
    assert angles[0] < 1e-4 and angles[-1] < 1e-4
    assert angles.max() > math.radians(20.0)
    bpy.context.scene.frame_set(1)
    assert rig.animation_data.action.name == range_of_motion.ACTION


def test_the_range_of_motion_keeps_the_action_that_was_there(muscled):
    _skin, rig = muscled
    rig.pose.bones["lower"].keyframe_insert("rotation_quaternion", frame=3)
    own = rig.animation_data.action
    select(rig)
    bpy.ops.sinew.range_of_motion()
    assert own.use_fake_user and rig.animation_data.action != own
    bpy.ops.sinew.range_of_motion()
    assert sum(action.name.startswith(range_of_motion.ACTION) for action in bpy.data.actions) == 1


def test_left_and_right_move_together(human):
    select(human)
    bpy.ops.sinew.grow_skin(resolution=40, unwrap=False)
    select(human)
    bpy.ops.sinew.range_of_motion(frames=1, twists=False)
    for left, right in (("forearm.L", "forearm.R"), ("thigh.L", "thigh.R")):
        assert np.abs(angles_of(human, left) - angles_of(human, right)).max() < 1e-3


def test_a_range_of_motion_needs_a_mesh(human):
    select(human)
    with pytest.raises(RuntimeError, match="has no mesh"):
        bpy.ops.sinew.range_of_motion()


def test_the_report_names_what_is_wrong(muscled):
    skin, rig = muscled
    skin.sinew.skin.iterations = 7
    bpy.data.objects["Muscle lower"].sinew.tissue.insertion_bone = "gone"
    bpy.context.view_layer.update()
    logging.getLogger("sinew").warning("Something happened")
    select(rig)
    bpy.ops.sinew.whats_wrong()
    text = bpy.data.texts[whats_wrong.TEXT].as_string()
    for words in (
        f"Sinew {whats_wrong.version()}", f"Blender {bpy.app.version_string}", "Armature Arm Rig: 2 bones", "480 vertices",
        "iterations=7", "insertion bone 'gone'", "WARNING Something happened",
    ):  # fmt: skip
        assert words in text, words
    assert whats_wrong.version()[0].isdigit()


def test_the_report_of_an_empty_file(empty_file):
    bpy.ops.sinew.whats_wrong()
    assert "0 objects" in bpy.data.texts[whats_wrong.TEXT].as_string()


def test_the_log_is_also_written_to_a_file(tmp_path):
    path = tmp_path / "sinew.log"
    log.write_to(str(path))
    logging.getLogger("sinew").error("To the file")
    log.write_to("")
    logging.getLogger("sinew").error("Not to the file")
    assert "To the file" in path.read_text() and "Not to" not in path.read_text()
    assert any("Not to the file" in line for line in log.last_lines())
    assert len(log.last_lines()) <= log.MOST_LINES
