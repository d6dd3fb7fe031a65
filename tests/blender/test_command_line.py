# SPDX-License-Identifier: GPL-3.0-or-later
"""The command line, run by the function that Blender calls: written files, output, exit codes and errors."""

import importlib
import json

import bpy
import numpy as np
import pytest
from bl_ext.user_default.sinew import command_line
from bl_ext.user_default.sinew.bake.cache import point_cache
from conftest import FLEXOR, add_muscle, bind, make_arm, points_over, select
from test_point_cache import add_smile

FRAMES = range(1, 13)


@pytest.fixture
def saved(waving, tmp_path):
    """The path of a file with the waving arm, and its live points over the frames."""
    skin, _rig = waving
    live = points_over(skin, FRAMES)
    path = tmp_path / "arm.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(path))
    return path, live


@pytest.fixture
def command(capfd):
    """Runs a command line; returns its exit code, standard output (parsed if JSON was requested) and error."""

    def run(*arguments):
        capfd.readouterr()
        code = command_line.run([str(argument) for argument in arguments])
        out, err = capfd.readouterr()
        if "--json" not in arguments:
            return code, out, err
        (line,) = [line for line in out.splitlines() if line.startswith("{")]
        return code, json.loads(line), err

    return run


def bake(command, saved, output, *arguments):
    return command("bake", saved[0], "--object", "Arm", "--frames", "1..12", "--output", output, *arguments)


def test_a_bake_of_all_frames(command, saved, tmp_path):
    code, result, err = bake(command, saved, tmp_path / "out", "--json", "--points", "posed")
    path = tmp_path / "out" / "Arm.pc2"
    assert (code, result["ok"], result["warnings"]) == (0, True, [])
    assert result["files"] == [{"object": "Arm", "path": str(path), "bytes": path.stat().st_size}]
    assert "sinew: baking frames 1 to 12: 100%" in err
    assert np.array_equal(point_cache.read(path, "PC2").samples, saved[1])


@pytest.mark.parametrize("file_format", ["pc2", "mdd"])
@pytest.mark.parametrize("of", [1, 2, 7])
def test_chunks_give_the_same_bytes_as_one_bake(command, saved, tmp_path, of, file_format):
    """Chunks are baked in any order, each in a Blender that evaluated other frames before."""
    whole, parts = tmp_path / "whole", tmp_path / "parts"
    assert bake(command, saved, whole, "--format", file_format)[0] == 0
    for number in sorted(range(1, of + 1), key=lambda number: number * 5 % 7):
        bpy.ops.wm.open_mainfile(filepath=str(saved[0]))
        bpy.context.scene.frame_set(9)
        assert bake(command, saved, parts, "--format", file_format, "--chunk", f"{number}/{of}")[0] == 0
    assert command("merge", parts)[0] == 0
    name = f"Arm.{file_format}"
    assert (parts / name).read_bytes() == (whole / name).read_bytes()


def test_a_mesh_that_moves_by_rounding_is_bound_alike_in_every_chunk(command, tmp_path):
    """Far from the origin, rounding moves the mesh relative to its armature. The bind must not depend on when it is made."""
    skin, rig = make_arm()
    rig.location = (9.0, -7.0, 3.0)
    add_muscle(rig, around=FLEXOR)
    bind(skin)
    bone = rig.pose.bones["lower"]
    bone.rotation_mode = "XYZ"
    for frame, angle in ((1, 0.0), (8, 1.4)):
        bone.rotation_euler[2] = angle
        bone.keyframe_insert("rotation_euler", frame=frame)
        rig.rotation_euler = (angle, angle / 2, 0.1)
        rig.keyframe_insert("rotation_euler", frame=frame)
    # in one frame more than rounding, so that this frame binds again, and so does the next
    bpy.context.preferences.edit.keyframe_new_interpolation_type = "CONSTANT"
    for frame, skin.location.x in ((1, 0.0), (4, 2e-4), (5, 0.0)):
        skin.keyframe_insert("location", frame=frame)
    path = tmp_path / "off.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(path))
    common = ("bake", path, "--object", "Arm", "--frames", "1..8")
    assert command(*common, "--output", tmp_path / "whole")[0] == 0
    for number in range(1, 5):
        assert command(*common, "--output", tmp_path / "parts", "--chunk", f"{number}/4")[0] == 0
    assert command("merge", tmp_path / "parts")[0] == 0
    assert (tmp_path / "parts" / "Arm.pc2").read_bytes() == (tmp_path / "whole" / "Arm.pc2").read_bytes()


def test_a_merged_blend_plays_as_live(command, saved, tmp_path):
    for number in (1, 2, 3):
        bake(command, saved, tmp_path / "parts", "--chunk", f"{number}/3")
    out = tmp_path / "played" / "arm.blend"
    out.parent.mkdir()
    code, result, _err = command(
        "merge", tmp_path / "parts", "--blend", out, "--file", saved[0], "--remove-chunks", "--json"
    )
    assert code == 0 and result["blend"] == str(out)
    assert [path.name for path in (tmp_path / "parts").iterdir()] == ["Arm.pc2"]
    bpy.ops.wm.open_mainfile(filepath=str(out))
    skin = bpy.data.objects["Arm"]
    assert skin.modifiers["Sinew Cache"].filepath == "//../parts/Arm.pc2" and not skin.sinew.skin.live
    assert np.array_equal(points_over(skin, FRAMES), saved[1])


@pytest.mark.parametrize("up", ["z", "y"])
def test_a_merge_into_shape_keys_plays_without_sinew(command, waving, tmp_path, up):
    import addon_utils

    skin, _rig = waving
    add_smile(skin)
    live = points_over(skin, FRAMES)
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "arm.blend"))
    saved = tmp_path / "arm.blend", live
    for number in (1, 2):
        bake(command, saved, tmp_path / "parts", "--up", up, "--chunk", f"{number}/2")
    keyed = ("merge", tmp_path / "parts", "--blend", tmp_path / "keyed.blend", "--file", tmp_path / "arm.blend", "--keys")
    assert command(*keyed)[0] == 0
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "keyed.blend"))
    skin = bpy.data.objects["Arm"]
    assert len(skin.data.shape_keys.key_blocks) == 14 and [m.type for m in skin.modifiers] == ["NODES", "ARMATURE"]
    addon_utils.disable("bl_ext.user_default.sinew")
    assert np.abs(points_over(skin, FRAMES) - live).max() < 1e-6
    addon_utils.enable("bl_ext.user_default.sinew")
    select(bpy.data.objects["Arm Rig"])
    bpy.ops.sinew.remove()
    assert skin.data.shape_keys.key_blocks.keys() == ["Basis", "Smile"]


def test_chunks_that_do_not_belong_together_are_refused(command, saved, tmp_path):
    parts = tmp_path / "parts"
    for number in (1, 3):
        bake(command, saved, parts, "--chunk", f"{number}/3")
    (parts / ".Arm.2-of-3.pc2.elsewhere.1.01234567.sinew-part.json").write_text('{"sinew_chu')
    (parts / "notes.json").write_text('["a person\'s"]')
    code, _out, err = command("merge", parts)
    assert code == 3 and "of 3 chunks 2 is missing" in err
    bake(command, saved, parts, "--chunk", "2/3", "--points", "posed")
    code, _out, err = command("merge", parts)
    assert code == 3 and "points is BEFORE_ARMATURE in chunk 1 and POSED in chunk 2" in err
    bake(command, saved, parts, "--chunk", "2/3")
    with open(parts / "Arm.2-of-3.pc2", "r+b") as file:
        file.seek(100)
        file.write(b"x")
    code, _out, err = command("merge", parts)
    assert code == 3 and "Bake chunk 2 again" in err
    assert not (parts / "Arm.pc2").exists()
    bake(command, saved, parts, "--chunk", "2/3")
    assert command("merge", parts)[0] == 0


def test_chunks_of_a_file_that_changed_are_refused(command, saved, tmp_path):
    bake(command, saved, tmp_path / "parts", "--chunk", "1/2")
    bpy.data.objects["Arm"].sinew.skin.muscle_influence = 2.0
    bpy.ops.wm.save_mainfile()
    bake(command, saved, tmp_path / "parts", "--chunk", "2/2")
    code, _out, err = command("merge", tmp_path / "parts")
    assert code == 3 and "source is" in err


def test_a_scene_that_is_not_the_current_one(command, saved, tmp_path):
    bpy.context.window.scene = bpy.data.scenes.new("Empty")
    bpy.ops.wm.save_mainfile()
    code, _out, err = bake(command, saved, tmp_path / "out")
    assert code == 3 and "is not in the scene Empty" in err
    for number in (1, 2):
        assert bake(command, saved, tmp_path / "out", "--scene", "Scene", "--chunk", f"{number}/2")[0] == 0
    assert command("merge", tmp_path / "out", "--blend", tmp_path / "played.blend", "--file", saved[0])[0] == 0
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "played.blend"))
    bpy.context.window.scene = bpy.data.scenes["Scene"]
    assert np.array_equal(points_over(bpy.data.objects["Arm"], FRAMES), saved[1])


def test_an_object_of_any_name(command, waving, tmp_path):
    skin, _rig = waving
    skin.name = "Ärm/体:*.001"
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "arm.blend"))
    arguments = ("bake", tmp_path / "arm.blend", "--object", skin.name, "--frames", "1..4", "--output", tmp_path / "out")
    for number in (1, 2):
        assert command(*arguments, "--chunk", f"{number}/2")[0] == 0
    code, result, _err = command("merge", tmp_path / "out", "--json")
    assert code == 0 and result["files"][0]["object"] == "Ärm/体:*.001"
    assert (tmp_path / "out" / "Ärm%2F体%3A%2A.001.pc2").is_file()


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ((), "VERB"),
        (("boil",), "invalid choice"),
        (("bake",), "required"),
        (("bake", "a.blend", "--object", "Arm", "--output", "out", "--frames", "12..1"), "before the first"),
        (("bake", "a.blend", "--object", "Arm", "--output", "out", "--frames", "one"), "not a range of frames"),
        (("bake", "a.blend", "--object", "Arm", "--output", "out", "--chunk", "3/2"), "not a chunk"),
        (("bake", "a.blend", "--object", "Arm", "--output", "out", "--chunk", "0/2"), "not a chunk"),
        (("bake", "a.blend", "--object", "Arm", "--output", "out", "--step", "0"), "not a step"),
        (("bake", "a.blend", "--object", "Arm", "--output", "out", "--step", "9" * 5000), "not a step"),
        (("bake", "a.blend", "--object", "Arm", "--output", "out", "--frames", "1..9999999"), "Blender has the frames"),
        (("bake", "a.blend", "--object", "Arm", "--output", "out", "--frames", "9" * 5000), "not a range of frames"),
        (("measure", "a.blend", "--object", "Arm", "--degrees", "200"), "not an angle"),
        (("measure", "a.blend", "--object", "Arm", "--degrees", "nan"), "not an angle"),
        (("merge", "out", "--keys"), "--keys requires --blend"),
        (("merge", "out", "--blend", "a.blend"), "--blend requires --file"),
    ],
)
def test_wrong_arguments(command, arguments, words):
    code, _out, err = command(*arguments)
    assert code == 2 and words in err


@pytest.mark.parametrize(
    ("changed", "words"),
    [
        ({"file": "nowhere.blend"}, "There is no file"),
        ({"file": "a" * 300}, "There is no file"),
        ({"object": "Leg"}, "has no mesh 'Leg'; available: Arm"),
        ({"object": "Arm Rig"}, "has no mesh 'Arm Rig'"),
        ({"chunk": "1/13"}, "can't be split into 13"),
        ({"scene": "Other"}, "There is no scene 'Other'"),
    ],
)
def test_bad_input(command, saved, tmp_path, changed, words):
    wanted = {"file": str(saved[0]), "object": "Arm", "chunk": "1/2", "scene": "Scene"} | changed
    code, result, err = command(
        "bake", wanted["file"], "--object", wanted["object"], "--frames", "1..12", "--chunk", wanted["chunk"],
        "--scene", wanted["scene"], "--output", tmp_path / "out", "--json",
    )  # fmt: skip
    assert (code, result["ok"], result["exit_code"]) == (3, False, 3)
    assert words in result["error"] and words in err and not (tmp_path / "out").exists()


def test_a_file_that_is_not_a_blend(command, tmp_path):
    (tmp_path / "a.blend").write_text("no")
    code, _out, err = command("bake", tmp_path / "a.blend", "--object", "Arm", "--output", tmp_path)
    assert code == 3 and "could not be opened" in err


def test_a_mesh_that_is_not_bound(command, saved, tmp_path):
    select(bpy.data.objects["Arm"])
    bpy.ops.sinew.unbind()
    bpy.ops.wm.save_mainfile()
    code, _out, err = bake(command, saved, tmp_path)
    assert code == 3 and "not bound" in err


def test_a_file_that_cannot_be_written(command, saved, tmp_path):
    (tmp_path / "taken").write_text("a person's")
    code, result, _err = bake(command, saved, tmp_path / "taken", "--json")
    assert code == 4 and "could not be made" in result["error"]
    (tmp_path / "Arm.pc2").mkdir()
    assert bake(command, saved, tmp_path)[0] == 4
    assert (tmp_path / "taken").read_text() == "a person's" and list((tmp_path / "Arm.pc2").iterdir()) == []
    code, _out, err = command("preset", saved[0], "--armature", "Arm Rig", "--preset", "human", "--save", tmp_path / "x")
    assert code == 3 and "Arm Rig" in err


def test_the_result_in_a_file(command, saved, tmp_path):
    code, out, _err = bake(command, saved, tmp_path, "--report", tmp_path / "result.json")
    assert code == 0 and "{" not in out and json.loads((tmp_path / "result.json").read_text())["ok"]
    for nowhere in (tmp_path / "nowhere" / "result.json", tmp_path / "result.json" / "below", tmp_path / ("a" * 300)):
        code, _out, err = bake(command, saved, tmp_path, "--report", nowhere)
        assert code == 4 and "could not be written" in err


def test_measure(command, saved):
    code, result, _err = command("measure", saved[0], "--object", "Arm", "--poses", "frames", "--frames", "12", "--json")
    assert code == 0 and {row["deformer"] for row in result["rows"]} >= {"Sinew", "Linear"}
    code, out, _err = command("measure", saved[0], "--object", "Arm", "--poses", "frames", "--frames", "12")
    assert code == 0 and "Corrective Smooth" in out
    code, _out, err = command("measure", saved[0], "--object", "Arm", "--bone", "tail")
    assert code == 3 and "tail" in err


def test_preset_binds_and_saves(command, body_file, tmp_path):
    out = tmp_path / "body.blend"
    code, result, _err = command(
        "preset", body_file, "--armature", "Rig", "--preset", "limbs", "--bind", "Body", "--save", out, "--json"
    )
    assert code == 0 and result["tissues"] == 70 and result["bound"][0]["vertices"] == 13380
    bpy.ops.wm.open_mainfile(filepath=str(out))
    assert bpy.data.objects["Body"].sinew.skin.bound and [path.name for path in tmp_path.iterdir()] == ["body.blend"]
    code, _out, err = command("preset", body_file, "--armature", "Rig", "--preset", "octopus", "--save", out)
    assert code == 3 and "human" in err


def test_help(command):
    code, out, _err = command("--help")
    assert code == 0 and "exit codes" in out and all(verb in out for verb in ("bake", "merge", "measure", "preset"))
    assert command("bake", "--help")[0] == 0


def test_the_command_is_registered_with_the_extension():
    """The bpy module has no command line, so the test cannot check that Blender runs the command."""
    import addon_utils

    assert command_line._registered is not None
    addon_utils.disable("bl_ext.user_default.sinew")
    assert command_line._registered is None
    addon_utils.enable("bl_ext.user_default.sinew")
    assert importlib.import_module("bl_ext.user_default.sinew.command_line")._registered is not None
