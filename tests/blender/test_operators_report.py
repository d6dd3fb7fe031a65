# SPDX-License-Identifier: GPL-3.0-or-later
"""Operators end in a report, never in a traceback: impossible numbers, no bones, no file, excluded collections."""

import math

import bpy
import pytest
from bl_ext.user_default.sinew.errors import SinewError
from bl_ext.user_default.sinew.files import strict_json
from bl_ext.user_default.sinew.muscles.placing.place import preset_file
from conftest import FLEXOR, add_muscle, bind, select

ALL = dir(bpy.ops.sinew)
OF_THE_SCENE = [name for name in ALL if name != "example_character"]  # it makes a scene of its own, which takes seconds
IN_POSE_MODE = {"reach", "rotate_joint", "add_goal", "rest_pose", "copy_bone_settings"}


def settings_of(name):
    return {found.identifier: found for found in getattr(bpy.ops.sinew, name).get_rna_type().properties}


def outcome(operator_name, tmp_path, **settings):
    """Calls an operator; returns the text of its error reports. Fails if it raised anything else."""
    known = settings_of(operator_name)
    few = {
        "frame_end": 2,
        "folder": str(tmp_path),
        "memory_limit": 500,
        "most_keys": 2,
        "combinations": 0,
        "angles": "X 0..20",
    }
    settings = {name: value for name, value in few.items() if name in known} | settings
    try:
        assert getattr(bpy.ops.sinew, operator_name)(**settings) == {"FINISHED"}
    except RuntimeError as error:
        assert "Traceback" not in str(error), str(error)
        return str(error)
    return ""


def floats():
    return [(name, identifier) for name in ALL for identifier, found in settings_of(name).items() if found.type == "FLOAT"]


@pytest.mark.one_blender
@pytest.mark.parametrize("value", [3.4e38, -3.4e38, math.nan, math.inf, -math.inf])
@pytest.mark.parametrize(("name", "identifier"), floats())
def test_impossible_numbers(arm, tmp_path, name, identifier, value):
    skin, rig = arm
    muscle = add_muscle(rig, around=FLEXOR)
    bind(skin)
    select(muscle if name in ("add_via_point", "drag_handle") else rig)
    if name in IN_POSE_MODE:
        bpy.ops.object.mode_set(mode="POSE")
        rig.data.bones.active = rig.data.bones["lower"]
    found = settings_of(name)[identifier]
    settings = {identifier: (value,) * found.array_length if found.is_array else value}
    report = outcome(name, tmp_path, **settings, **({"bone": "lower"} if name == "reach" else {}))
    if math.isnan(value):
        assert found.name in report and "not a number" in report
    assert all(math.isfinite(number) for empty in rig.children for row in empty.matrix_basis for number in row)


@pytest.mark.parametrize("name", OF_THE_SCENE)
@pytest.mark.parametrize("active", ["armature", "armature in Pose Mode", "mesh", "muscle"])
def test_an_armature_without_bones(name, active, tmp_path):
    rig = bpy.data.objects.new("Boneless", bpy.data.armatures.new("Boneless"))
    mesh = bpy.data.meshes.new("Mesh")
    mesh.from_pydata([(0, 0, 0), (1, 0, 0), (0, 1, 0)], [], [(0, 1, 2)])
    skin, muscle = bpy.data.objects.new("Mesh", mesh), bpy.data.objects.new("Muscle", None)
    for found in (rig, skin, muscle):
        bpy.context.scene.collection.objects.link(found)
    skin.parent = muscle.parent = rig
    skin.modifiers.new("Armature", "ARMATURE").object = rig
    muscle.sinew.tissue.kind = "MUSCLE"
    select({"mesh": skin, "muscle": muscle}.get(active, rig))
    if active == "armature in Pose Mode":
        bpy.ops.object.mode_set(mode="POSE")
    outcome(name, tmp_path)


@pytest.mark.parametrize("filepath", ["", "//", "/"])
@pytest.mark.parametrize("name", ["export", "save_musculature", "load_musculature"])
def test_no_file_name(arm, tmp_path, name, filepath):
    skin, rig = arm
    add_muscle(rig)
    bind(skin)
    select(rig)
    assert "file name" in outcome(name, tmp_path, filepath=filepath)


def excluded(muscle):
    """Excludes the collection of the muscles from the view layer."""
    (collection,) = muscle.users_collection
    layer = bpy.context.view_layer.layer_collection.children[collection.name]
    layer.exclude = True
    bpy.context.view_layer.update()
    assert muscle.name not in bpy.context.view_layer.objects


@pytest.mark.parametrize("name", OF_THE_SCENE)
def test_muscles_in_an_excluded_collection(arm, tmp_path, name):
    skin, rig = arm
    muscle = add_muscle(rig, around=FLEXOR)
    bind(skin)
    if name == "remove_via_points":
        select(muscle)
        bpy.ops.sinew.add_via_point()
    select(rig)
    excluded(muscle)
    if name in IN_POSE_MODE:
        bpy.ops.object.mode_set(mode="POSE")
        rig.data.bones.active = rig.data.bones["lower"]
    if name in ("add_via_point", "remove_via_points", "mirror", "copy_settings"):
        with bpy.context.temp_override(object=muscle, active_object=muscle, selected_objects=[muscle]):
            report = outcome(name, tmp_path)
    else:
        report = outcome(name, tmp_path, **({"bone": "lower"} if name == "reach" else {}))
    if name in ("add_via_point", "remove_via_points"):
        assert report == ""


@pytest.mark.parametrize("name", ["\ud800", "\udcff", "\ud800.json", "\udcff.json", "a\x00b", "a\x00b.json"])
def test_a_preset_name_that_no_file_can_have(name):
    with pytest.raises(SinewError) as refused:
        preset_file.read(name)
    str(refused.value).encode()  # the panels and the console can show it


@pytest.mark.parametrize("name", ["\ud800.json", "\udcff.json", "a\x00b.json"])
def test_a_file_name_that_no_file_can_have(name):
    from pathlib import Path

    with pytest.raises(SinewError) as refused:
        strict_json.read(Path(name))
    str(refused.value).encode()


@pytest.mark.parametrize("option", ["--armature", "--preset", "--bind", "--scene"])
def test_a_name_on_the_command_line_that_no_object_can_have(arm, tmp_path, capfd, option):
    from bl_ext.user_default.sinew import command_line

    path = tmp_path / "arm.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(path))
    options = {"--armature": "Arm Rig", "--preset": "limbs", "--save": str(tmp_path / "out.blend")} | {option: "\udcff"}
    code = command_line.run(["preset", str(path), *(text for pair in options.items() for text in pair)])
    assert code == command_line.BAD_INPUT and "Traceback" not in capfd.readouterr().err
