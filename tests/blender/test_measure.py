# SPDX-License-Identifier: GPL-3.0-or-later
"""`sinew.measure`: Sinew compared with Blender's deformers. Measuring leaves nothing behind."""

import json
import math

import bpy
import numpy as np
import pytest
from conftest import FLEXOR, add_muscle, armature_alone, bend, bind, evaluated_points, key_bend, select

pytestmark = pytest.mark.one_blender

DEFORMERS = ["Sinew", "Linear", "Preserve Volume", "Corrective Smooth"]
HEAT_MAP = "sinew_stretch"


@pytest.fixture
def elastic_arm(arm):
    """(mesh, rig): an elastic arm, bent by 1.4 in frame 10, with a muscle that is tense from frame 5 on."""
    skin, rig = arm
    muscle = add_muscle(rig, around=FLEXOR)
    for frame, muscle.sinew.tissue.tension in ((4, 0.0), (5, 1.0)):
        muscle.sinew.tissue.keyframe_insert("tension", frame=frame)
    skin.sinew.skin.elastic = True
    bind(skin)
    key_bend(rig, {1: 0.0, 10: 1.4})
    bpy.context.scene.frame_set(10)
    return skin, rig


def measure(skin, **settings):
    """The rows of a measurement, from its JSON."""
    select(skin)
    assert bpy.ops.sinew.measure(**{"poses": "CURRENT", "json": True} | settings) == {"FINISHED"}
    return json.loads(skin.sinew.skin.quality_json.as_string())["rows"]


def row_of(rows, deformer, region="whole skin", pose=None):
    return next(r for r in rows if r["deformer"] == deformer and r["region"] == region and pose in (None, r["pose"]))


def state_of(skin, rig):
    """The state that a measurement must not change."""
    scene = bpy.context.scene
    return {
        "objects": sorted(bpy.data.objects.keys()),
        "meshes": sorted(bpy.data.meshes.keys()),
        "armatures": sorted(bpy.data.armatures.keys()),
        "users": (skin.data.users, rig.data.users),
        "modifiers": [(m.name, m.show_viewport, m.show_render) for m in skin.modifiers],
        "pose": [tuple(v for row in bone.matrix_basis for v in row) for bone in rig.pose.bones],
        "modes": [bone.rotation_mode for bone in rig.pose.bones],
        "frame": (scene.frame_current, scene.frame_subframe),
        "live": skin.sinew.skin.live,
        "active": bpy.context.view_layer.objects.active.name,
        "selected": sorted(found.name for found in bpy.context.selected_objects),
        "points": evaluated_points(skin).tobytes(),
    }


def test_each_deformer_has_the_points_that_blender_shows(elastic_arm):
    """The measured points are those of the modifiers."""
    from bl_ext.user_default.sinew.measure import deformers
    from bl_ext.user_default.sinew.scene import characters

    skin, rig = elastic_arm
    bpy.context.scene.frame_set(3)
    sinew = deformers.SinewDeformer(skin, rig, characters.tissues_of(rig))
    measured = deformers.Deformers(bpy.context.scene, skin, rig, posed_freely=False)
    bpy.context.scene.frame_set(10)
    found = measured.points(sinew)
    measured.remove()
    assert list(found) == DEFORMERS
    assert np.abs(found["Sinew"] - evaluated_points(skin)).max() < 2e-6
    assert np.abs(found["Linear"] - armature_alone(skin)).max() < 1e-6
    skin.modifiers["Armature"].use_deform_preserve_volume = True
    assert np.abs(found["Preserve Volume"] - armature_alone(skin)).max() < 1e-6
    skin.modifiers["Armature"].use_deform_preserve_volume = False
    smooth = skin.modifiers.new("Smooth", "CORRECTIVE_SMOOTH")
    smooth.rest_source = "ORCO"
    assert np.abs(found["Corrective Smooth"] - armature_alone(skin)).max() < 1e-6


def test_the_current_pose(elastic_arm):
    skin, rig = elastic_arm
    before = state_of(skin, rig)
    rows = measure(skin)
    assert state_of(skin, rig) == before
    assert [row["deformer"] for row in rows if row["region"] == "lower"] == DEFORMERS
    sinew, linear = row_of(rows, "Sinew", "lower"), row_of(rows, "Linear", "lower")
    assert abs(sinew["union"] - 1.0) < 0.01 < abs(linear["union"] - 1.0)
    assert {row["pose"] for row in rows} == {"frame 10"}
    assert "lower" in skin.sinew.skin.quality_text.as_string() and "Worst" in skin.sinew.skin.quality_summary


def test_frames(elastic_arm):
    skin, rig = elastic_arm
    before = state_of(skin, rig)
    rows = measure(skin, poses="FRAMES", frame_start=1, frame_end=10, step=3)
    assert state_of(skin, rig) == before
    assert {row["pose"] for row in rows} == {f"frame {frame}" for frame in (1, 4, 7, 10)}
    assert row_of(rows, "Linear", pose="frame 1")["edge_max"] == pytest.approx(1.0, abs=1e-4)
    assert row_of(rows, "Linear", pose="frame 10")["edge_max"] > 1.2
    assert row_of(measure(skin), "Sinew") == pytest.approx(row_of(rows, "Sinew", pose="frame 10"), abs=1e-3)


def test_every_joint_that_muscles_cross(elastic_arm):
    skin, rig = elastic_arm
    before = state_of(skin, rig)
    rows = measure(skin, poses="JOINTS", angle=math.radians(80), angle_steps=2)
    assert state_of(skin, rig) == before
    # the arm is straight at rest, so it is bent in both directions
    assert list(dict.fromkeys(row["pose"] for row in rows)) == [f"lower {turn}°" for turn in ("-80", "-40", "+40", "+80")]
    far, near = (row_of(rows, "Linear", "lower", f"lower {turn}°") for turn in ("+80", "+40"))
    assert far["union"] < near["union"] < 1.0


def test_real_joints_bend_as_their_muscles_turn_them(real_body):
    from bl_ext.user_default.sinew.live import session

    skin, rig = real_body
    select(rig)
    bpy.ops.sinew.add_preset(name="limbs")
    bind(skin)
    state = session.cached_rig(rig)
    names = {frame: name for name, frame in state.rest.index_of_bone.items()}
    joints = {names[frame]: (axis, one_way) for frame, axis, one_way in state.musculature.joints()}
    for side in "LR":
        # the body faces -Y, so a knee flexes about +X
        (x, y, z), one_way = joints[f"lowerleg01.{side}"]
        assert x > 0.99 and one_way
        (x, y, z), one_way = joints[f"lowerarm01.{side}"]
        assert one_way and abs(y) < 0.2
        (x, y, z), one_way = joints[f"upperleg01.{side}"]
        assert abs(x) > 0.85 and not one_way


def test_selected_bones_about_their_own_axes(elastic_arm):
    skin, rig = elastic_arm
    select(rig)
    bpy.ops.object.mode_set(mode="POSE")
    rig.data.bones.active = rig.data.bones["lower"]
    bpy.ops.pose.select_all(action="SELECT")
    assert bpy.ops.sinew.measure(poses="JOINTS", bones="SELECTED", axis="Y", angle_steps=1, json=True) == {"FINISHED"}
    rows = json.loads(skin.sinew.skin.quality_json.as_string())["rows"]
    assert rig.mode == "POSE"
    twist = row_of(rows, "Linear", "lower", "lower +90°")
    kept = row_of(rows, "Preserve Volume", "lower", "lower +90°")
    assert twist["union"] < 0.9 < kept["union"]
    bpy.ops.pose.select_all(action="DESELECT")
    with pytest.raises(RuntimeError, match="No bones are selected"):
        bpy.ops.sinew.measure(poses="JOINTS", bones="SELECTED")


def test_a_hidden_armature(elastic_arm):
    skin, rig = elastic_arm
    shown = measure(skin)
    rig.hide_viewport = True
    bpy.context.view_layer.update()
    assert measure(skin) == shown
    assert measure(skin, poses="JOINTS", angle_steps=1)


def test_an_error_during_measurement_leaves_nothing(elastic_arm, monkeypatch):
    from bl_ext.user_default.sinew.measure.measurement import Measurement

    skin, rig = elastic_arm
    select(skin)
    before = state_of(skin, rig)

    def fail(*_):
        raise ValueError("a bone went wrong")

    monkeypatch.setattr(Measurement, "_measure", fail)
    for poses in ("FRAMES", "JOINTS"):
        with pytest.raises(RuntimeError, match="a bone went wrong"):
            bpy.ops.sinew.measure(poses=poses)
        bpy.context.view_layer.update()
        assert state_of(skin, rig) == before


def test_a_mesh_that_is_not_bound(arm):
    skin, rig = arm
    bend(rig, 1.4)
    rows = measure(skin)
    assert [row["deformer"] for row in rows if row["region"] == "whole skin"] == DEFORMERS[1:]


def test_the_heat_map_and_its_removal(elastic_arm):
    skin, rig = elastic_arm
    measure(skin, heat_map=True)
    colours = np.empty((len(skin.data.vertices), 4), np.float32)
    skin.data.color_attributes[HEAT_MAP].data.foreach_get("color", colours.reshape(-1))
    assert skin.data.color_attributes.active_color.name == HEAT_MAP
    assert np.allclose(colours[:20, :3], 0.9, atol=0.01)  # the end at the shoulder is at rest
    assert (colours[:, 0] > colours[:, 2] + 0.2).any() and (colours[:, 2] > colours[:, 0] + 0.05).any()
    measure(skin)
    assert HEAT_MAP not in skin.data.color_attributes  # it belonged to another measurement
    measure(skin, heat_map=True)
    bpy.ops.sinew.unbind()
    assert HEAT_MAP not in skin.data.color_attributes
    measure(skin, heat_map=True)
    select(rig)
    bpy.ops.sinew.remove()
    assert HEAT_MAP not in skin.data.color_attributes and not bpy.data.texts


def test_the_requested_file_is_written(elastic_arm, tmp_path):
    skin, _rig = elastic_arm
    path = tmp_path / "quality.json"
    rows = measure(skin, filepath=str(path))
    assert json.loads(path.read_text())["rows"] == rows
    with pytest.raises(RuntimeError, match="could not be written"):
        bpy.ops.sinew.measure(poses="CURRENT", filepath=str(tmp_path / "no" / "folder.json"))


def test_a_cancelled_measurement_leaves_nothing(elastic_arm):
    from bl_ext.user_default.sinew.measure.measurement import Measurement, Settings

    skin, rig = elastic_arm
    for poses in ("FRAMES", "JOINTS"):
        before = state_of(skin, rig)
        measurement = Measurement(skin, bpy.context.scene, Settings(poses, range(1, 11), None, 90.0, 3, "MUSCLES"))
        next(measurement.steps())
        measurement.end()
        bpy.context.view_layer.update()
        assert state_of(skin, rig) == before


def test_the_real_body_has_the_numbers_of_an_independent_program():
    """Blender's deformers on the MakeHuman body, compared with docs/mathematics/quality.md, Comparison with Blender."""
    from benchmarks.quality_character import LINEAR, PRESERVE_VOLUME, Character

    character = Character("limbs", iterations=None)
    character.add_blenders_own()
    for joint, degrees, deformer, due in (
        ("elbow.L", 120, LINEAR, (0.839, 2.04, 25, 46, 112)),
        ("elbow.L", 90, PRESERVE_VOLUME, (0.933, 2.72, 9, 20, 96)),
        ("knee.L", 140, LINEAR, (0.790, 2.40, 3, 79, 104)),
        ("hip.L", 90, LINEAR, (0.802, 3.49, 15, 66, 84)),
        ("shoulder.L", 135, PRESERVE_VOLUME, (1.095, 2.90, 0, 0, 59)),
        ("forearm_twist.L", 90, LINEAR, (0.773, 1.75, 0, 0, 25)),
    ):
        character.pose({joint: degrees})
        found = character.surface.deformed(character.points(deformer)).quality(character.region(joint))
        assert found.union == pytest.approx(due[0], abs=6e-4)
        assert found.edge_p99 == pytest.approx(due[1], abs=6e-3)
        assert (found.inverted, found.new_intersections) == due[2:4]
        assert found.bend_p99 == pytest.approx(due[4], abs=1.0)


def test_scale_changes_no_number(elastic_arm):
    skin, rig = elastic_arm
    plain = measure(skin)
    rig.scale = (100.0, 100.0, 100.0)
    bpy.context.view_layer.update()
    for now, before in zip(measure(skin), plain, strict=True):
        assert now["edge_p99"] == pytest.approx(before["edge_p99"], rel=1e-3)
        assert now["union"] == pytest.approx(before["union"], abs=1e-3)
        assert (now["inverted"], now["new_hits"]) == (before["inverted"], before["new_hits"])


@pytest.mark.parametrize(
    ("spoil", "words"),
    [
        (lambda skin, rig: setattr(rig.data, "pose_position", "REST"), "Pose Position"),
        (lambda skin, rig: setattr(skin, "hide_viewport", True), "hidden"),
        (lambda skin, rig: setattr(rig, "scale", (0.0, 0.0, 0.0)), "scale of 0"),
        (lambda skin, rig: skin.data.clear_geometry(), "no faces"),
        (lambda skin, rig: bpy.ops.sinew.bake_shape_keys(frame_start=1, frame_end=2, tolerance=1e-6), "Live"),
    ],
)
def test_impossible_measurements_are_reported(elastic_arm, spoil, words):
    skin, rig = elastic_arm
    select(skin)
    spoil(skin, rig)
    bpy.context.view_layer.update()
    objects = sorted(bpy.data.objects.keys())
    with pytest.raises(RuntimeError, match=words):
        bpy.ops.sinew.measure(poses="JOINTS")
    assert sorted(bpy.data.objects.keys()) == objects
