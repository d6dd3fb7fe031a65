# SPDX-License-Identifier: GPL-3.0-or-later
"""Musculature files: the same bytes after a round trip, and other characters."""

import json
from dataclasses import replace

import bpy
import pytest
from bl_ext.user_default.sinew.files import strict_json
from bl_ext.user_default.sinew.muscles import edit
from bl_ext.user_default.sinew.muscles.file import reader, writer
from bl_ext.user_default.sinew.scene import characters, tissue_empty
from conftest import add_muscle, bend, bind, make_arm, select
from mathutils import Matrix, Vector


def save(rig, path):
    select(rig)
    bpy.ops.sinew.save_musculature(filepath=str(path))
    return path.read_bytes()


def load(rig, path, **settings):
    select(rig)
    bpy.ops.sinew.load_musculature(filepath=str(path), **settings)


def shapes_of(rig):
    return [tissue_empty.read(empty, rig) for empty in characters.tissues_of(rig)]


def add_some(rig):
    """One tissue of each kind, without default values."""
    add_muscle(rig, name="Biceps", around=1.3).sinew.tissue.tension = 0.35
    add_muscle(rig, name="Triceps", around=-1.3, offset=0.2)
    for kind in ("BONE", "STUFFING", "SPHERE"):
        bpy.ops.sinew.add_tissue(kind=kind, origin_bone="lower", name=kind.title())
    for place, empty in enumerate(characters.tissues_of(rig)):
        empty.rotation_euler.rotate_axis("Z", 0.4 * place)
        empty.scale.x *= 1.1
        empty.location.z += 0.003 * place
    bpy.context.view_layer.update()


def assert_same(before, after, within):
    assert [shape.name for shape in before] == [shape.name for shape in after]
    for own, other in zip(before, after):
        assert (own.kind, own.origin_bone, own.insertion_bone) == (other.kind, other.origin_bone, other.insertion_bone)
        assert (own.origin - other.origin).length < within and (own.insertion - other.insertion).length < within
        assert (own.semi_axes - other.semi_axes).length < within
        assert abs((own.rotation @ Vector((1, 0, 0))).dot(other.rotation @ Vector((1, 0, 0)))) > 1 - 1e-6
        assert abs(own.origin_tendon - other.origin_tendon) < within
        assert abs(own.volume_keeping - other.volume_keeping) < 1e-6


def test_save_load_save_is_the_same_bytes(arm, tmp_path):
    _skin, rig = arm
    add_some(rig)
    before, first = shapes_of(rig), save(rig, tmp_path / "arm.json")
    load(rig, tmp_path / "arm.json")
    assert_same(before, shapes_of(rig), 1e-5)
    assert save(rig, tmp_path / "again.json") == first
    bpy.ops.sinew.remove()
    load(rig, tmp_path / "arm.json")
    assert save(rig, tmp_path / "again.json") == first
    assert bpy.data.objects["Biceps"].sinew.tissue.tension == pytest.approx(0.35)


def test_a_whole_body_is_the_same_bytes(real_body, tmp_path):
    _skin, rig = real_body
    select(rig)
    bpy.ops.sinew.add_preset(name="limbs")
    before, first = shapes_of(rig), save(rig, tmp_path / "body.json")
    bpy.ops.sinew.remove()
    load(rig, tmp_path / "body.json")
    assert_same(before, shapes_of(rig), 2e-5)
    assert save(rig, tmp_path / "again.json") == first


def test_an_edit_changes_only_its_lines_of_the_text(arm, tmp_path):
    """An edit of one tissue changes only its lines, and numbers have at most six digits."""
    _skin, rig = arm
    add_some(rig)
    first = save(rig, tmp_path / "a.json").decode().splitlines()
    bpy.data.objects["Biceps"].location.z += 0.01
    second = save(rig, tmp_path / "b.json").decode().splitlines()
    changed = [line for line, (own, other) in enumerate(zip(first, second)) if own != other]
    assert len(first) == len(second) and 1 <= len(changed) <= 3
    names = [entry["name"] for entry in json.loads("\n".join(first))["tissues"]]
    assert names == sorted(names)
    numbers = [number for line in first for number in line.replace(",", " ").replace("]", " ").split() if "." in number]
    assert all(
        len(number.strip("-[").replace(".", "").lstrip("0")) <= 6 for number in numbers if number.strip("-[")[0].isdigit()
    )


def test_another_character_gets_its_own_proportions(arm, tmp_path):
    """The other character is twice as large and rotated: lengths double, and positions rotate with the bones."""
    _skin, rig = arm
    add_some(rig)
    before = shapes_of(rig)
    save(rig, tmp_path / "arm.json")
    _other_skin, other = make_arm("Giant")
    select(other)
    bpy.ops.object.mode_set(mode="EDIT")
    turn = Matrix.Translation((0.1, 0.2, 0.3)) @ Matrix.Rotation(0.7, 4, (1, 2, 3)) @ Matrix.Scale(2.0, 4)
    for bone in other.data.edit_bones:
        z = turn.to_3x3() @ bone.z_axis
        bone.transform(turn)
        bone.align_roll(z)
    bpy.ops.object.mode_set(mode="OBJECT")
    load(other, tmp_path / "arm.json")
    after = shapes_of(other)
    assert len(after) == len(before)
    for own, twin in zip(before, after):
        assert twin.name.startswith(own.name)
        assert (turn @ own.origin - twin.origin).length < 1e-4
        assert (own.semi_axes * 2 - twin.semi_axes).length < 1e-4
    assert len(characters.tissues_of(rig)) == len(before)
    first = (tmp_path / "arm.json").read_text()
    again = save(other, tmp_path / "giant.json").decode()
    assert [entry["name"] for entry in json.loads(first)["tissues"]] == [e["name"] for e in json.loads(again)["tissues"]]
    load(other, tmp_path / "arm.json")
    assert len(characters.tissues_of(other)) == len(before)


def test_a_longer_forearm_gets_longer_muscles(arm, tmp_path):
    _skin, rig = arm
    add_muscle(rig, name="Biceps")
    save(rig, tmp_path / "arm.json")
    before = tissue_empty.read(bpy.data.objects["Biceps"], rig)
    select(rig)
    bpy.ops.object.mode_set(mode="EDIT")
    rig.data.edit_bones["lower"].tail.x = 0.9
    bpy.ops.object.mode_set(mode="OBJECT")
    load(rig, tmp_path / "arm.json")
    after = tissue_empty.read(bpy.data.objects["Biceps"], rig)
    assert (after.origin - before.origin).length < 1e-5
    assert (after.insertion - before.insertion).x == pytest.approx(0.03, abs=1e-4)
    assert after.semi_axes.x / after.semi_axes.z == pytest.approx(before.semi_axes.x / before.semi_axes.z, rel=1e-3)


def test_segments_map_tissues_to_rigs_with_other_names(real_body, rigify, tmp_path):
    """From MakeHuman to Rigify's human metarig, each muscle keeps its segment and its position on it."""
    _skin, rig = real_body
    select(rig)
    bpy.ops.sinew.add_preset(name="limbs")
    count = len(characters.tissues_of(rig))
    save(rig, tmp_path / "body.json")
    bpy.ops.object.armature_human_metarig_add()
    metarig = bpy.context.object
    load(metarig, tmp_path / "body.json")
    shapes = shapes_of(metarig)
    assert len(shapes) == count
    for shape in shapes:
        assert shape.origin_bone in metarig.data.bones
        side = shape.name.split(".")[1]
        assert shape.origin_bone.endswith(side) or "." not in shape.origin_bone or shape.origin_bone.startswith("spine")
        assert max(shape.semi_axes) < 0.35
    biceps = next(shape for shape in shapes if shape.name.startswith("Biceps brachii.L"))
    assert biceps.insertion_bone == "forearm.L"
    elbow = metarig.data.bones["forearm.L"].head_local
    assert (biceps.insertion - elbow).length < 0.4 * metarig.data.bones["forearm.L"].length
    left = [shape for shape in shapes if ".L" in shape.name]
    assert all(shape.centre.x > 0 for shape in left)


def test_via_points_and_wraps_are_saved_and_loaded(arm, tmp_path):
    _skin, rig = arm
    add_some(rig)
    own = writer.Writer(rig)
    shape = tissue_empty.read(bpy.data.objects["Biceps"], rig)
    shape = replace(
        shape, via_points=(("upper", Vector((0.2, 0.1, 0.05))), ("lower", Vector((0.35, 0.1, 0)))), wraps=("Sphere",)
    )
    text = '{"sinew_musculature": 1, "rig": "", "tissues": [\n' + own.tissue(shape, 0.0) + "]}"
    path = tmp_path / "via.json"
    path.write_text(text)
    (read, _tension), *_ = reader.Reader(rig, strict_json.read(path), {}).tissues
    assert [bone for bone, _ in read.via_points] == ["upper", "lower"] and read.wraps == ("Sphere",)
    for (_, own), (_, other) in zip(shape.via_points, read.via_points):
        assert (own - other).length < 1e-5


def test_curved_muscles_are_the_same_bytes(arm, tmp_path):
    _skin, rig = arm
    add_some(rig)
    shape = tissue_empty.read(bpy.data.objects["Biceps"], rig)
    vias = (("upper", Vector((0.2, 0.1, 0.05))), ("lower", Vector((0.35, 0.1, 0))))
    edit.add(rig, [replace(shape, via_points=vias, wraps=("Sphere",))])
    first = save(rig, tmp_path / "a.json")
    bpy.ops.sinew.remove()
    load(rig, tmp_path / "a.json")
    read = tissue_empty.read(bpy.data.objects["Biceps"], rig)
    assert read.wraps == ("Sphere",) and [bone for bone, _ in read.via_points] == ["upper", "lower"]
    assert save(rig, tmp_path / "b.json") == first
    load(rig, tmp_path / "a.json")
    assert save(rig, tmp_path / "b.json") == first
    _other_skin, other = make_arm("Second")
    load(other, tmp_path / "a.json")
    sphere = next(empty for empty in characters.tissues_of(other) if empty.name.startswith("Sphere"))
    twin = next(empty for empty in characters.tissues_of(other) if empty.name.startswith("Biceps"))
    assert tissue_empty.read(twin, other).wraps == (sphere.name,)
    assert [entry["name"] for entry in json.loads(save(other, tmp_path / "c.json"))["tissues"]] == [
        entry["name"] for entry in json.loads(first)["tissues"]
    ]


def test_the_skins_settings_are_saved_and_loaded(arm, tmp_path):
    skin, rig = arm
    add_muscle(rig)
    bind(skin)
    skin.sinew.skin.muscle_influence, skin.sinew.skin.falloff, skin.sinew.skin.motion_source, skin.sinew.skin.scale_fat = (
        1.7,
        0.06,
        "FULL",
        True,
    )
    save(rig, tmp_path / "arm.json")
    skin.sinew.skin.muscle_influence, skin.sinew.skin.falloff, skin.sinew.skin.motion_source, skin.sinew.skin.scale_fat = (
        1.0,
        0.0,
        "SWELLING",
        False,
    )
    load(rig, tmp_path / "arm.json")
    assert skin.sinew.skin.muscle_influence == pytest.approx(1.7) and skin.sinew.skin.falloff == pytest.approx(
        0.06, rel=1e-5
    )
    assert skin.sinew.skin.motion_source == "FULL" and skin.sinew.skin.scale_fat
    bend(rig, 1.0)


def test_elastic_settings_are_saved_and_may_be_missing(arm, tmp_path):
    skin, rig = arm
    add_muscle(rig)
    bind(skin)
    plain = {name: getattr(skin.sinew.skin, name) for name in ELASTIC}
    for name, value in ELASTIC.items():
        setattr(skin.sinew.skin, name, value)
    first = save(rig, tmp_path / "arm.json")
    for name, value in plain.items():
        setattr(skin.sinew.skin, name, value)
    load(rig, tmp_path / "arm.json")
    for name, value in ELASTIC.items():
        found = getattr(skin.sinew.skin, name)
        assert found == value if isinstance(value, (str, bool)) else found == pytest.approx(value, rel=1e-5)
    assert save(rig, tmp_path / "again.json") == first
    older = json.loads(first)
    older["skin"] = {name: value for name, value in older["skin"].items() if name not in ELASTIC}
    (tmp_path / "older.json").write_text(json.dumps(older))
    load(rig, tmp_path / "older.json")
    assert skin.sinew.skin.slack == pytest.approx(0.02, rel=1e-5)


ELASTIC = {
    "energy": "SPRINGS",
    "anchor_stiffness": 2.5,
    "edge_stiffness": 0.25,
    "fat_sliding": 0.5,
    "contacts": False,
    "safeguard": False,
    "slack": 0.02,
}


def test_a_file_of_sinew_0_1_is_read(arm, tmp_path):
    skin, rig = arm
    add_muscle(rig)
    bind(skin)
    settings, lower = skin.sinew.skin, rig.pose.bones["lower"].sinew
    settings.motion_source, settings.muscle_influence, settings.falloff, settings.slack = "FULL", 1.5, 0.0625, 0.125
    lower.slack = 2.0
    newer = json.loads(save(rig, tmp_path / "newer.json"))
    older = newer | {"sinew_musculature": 1}
    former = {"motion_source": "carry", "muscle_influence": "gain", "falloff": "reach", "slack": "rest_distance"}
    older["skin"] = {former.get(name, name): value for name, value in newer["skin"].items()}
    older["skin"]["collides"] = True  # without effect now
    older["bones"] = [{"bone": "lower", "rest_distance": 2.0}]
    (tmp_path / "older.json").write_text(json.dumps(older))
    settings.motion_source, settings.muscle_influence, settings.falloff, settings.slack = "SWELLING", 1.0, 0.0, 0.0
    lower.slack = 1.0
    load(rig, tmp_path / "older.json")
    assert (settings.motion_source, settings.muscle_influence, lower.slack) == ("FULL", 1.5, 2.0)
    assert (settings.falloff, settings.slack) == (pytest.approx(0.0625, rel=1e-5), pytest.approx(0.125, rel=1e-5))
    assert save(rig, tmp_path / "again.json") == (tmp_path / "newer.json").read_bytes()


def test_the_bones_settings_are_saved_and_loaded(arm, tmp_path):
    _skin, rig = arm
    add_muscle(rig)
    own = rig.pose.bones["lower"].sinew
    own.anchor_stiffness, own.crease = 2.5, 0.25
    first = save(rig, tmp_path / "arm.json")
    assert json.loads(first)["bones"] == [{"bone": "lower", "anchor_stiffness": 2.5, "crease": 0.25}]
    own.anchor_stiffness, rig.pose.bones["upper"].sinew.contact = 1.0, 0.5
    load(rig, tmp_path / "arm.json")
    assert (own.anchor_stiffness, own.crease, rig.pose.bones["upper"].sinew.contact) == (2.5, 0.25, 1.0)
    assert save(rig, tmp_path / "again.json") == first
    for field, value, words in (("crease", 1.5, "from 0 to 1"), ("creese", 1.0, "knows"), ("bone", 3, "text")):
        spoilt = json.loads(first)
        spoilt["bones"][0][field] = value
        (tmp_path / "spoilt.json").write_text(json.dumps(spoilt))
        with pytest.raises(RuntimeError, match=words):
            load(rig, tmp_path / "spoilt.json")
    strange = json.loads(first)
    strange["bones"][0]["bone"] = "wing"
    (tmp_path / "strange.json").write_text(json.dumps(strange))
    load(rig, tmp_path / "strange.json")
    assert own.crease == 1.0


def test_the_bones_settings_find_their_segment_on_another_rig(real_body, tmp_path):
    """Settings are stored by segment: on a rig with other names, all bones of the segment get them."""
    _skin, rig = real_body
    select(rig)
    bpy.ops.sinew.add_preset(name="limbs")
    rig.pose.bones["upperarm01.L"].sinew.muscle_influence = 0.5
    (entry,) = json.loads(save(rig, tmp_path / "body.json"))["bones"]
    assert entry == {"bone": "upperarm01.L", "role": "upper_arm.L", "muscle_influence": 0.5}
    other = json.loads((tmp_path / "body.json").read_text())
    other["rig"], other["bones"][0]["bone"] = "another", "LeftArm"
    (tmp_path / "other.json").write_text(json.dumps(other))
    load(rig, tmp_path / "other.json")
    influences = {bone.name: bone.sinew.muscle_influence for bone in rig.pose.bones if bone.sinew.muscle_influence != 1.0}
    assert influences == {"upperarm01.L": 0.5, "upperarm02.L": 0.5}


def test_a_pose_does_not_matter(arm, tmp_path):
    _skin, rig = arm
    add_some(rig)
    first = save(rig, tmp_path / "a.json")
    bend(rig, 1.2)
    rig.rotation_euler = (0.1, 0.2, 0.3)
    bpy.context.view_layer.update()
    assert save(rig, tmp_path / "b.json") == first
    load(rig, tmp_path / "a.json")
    assert save(rig, tmp_path / "b.json") == first


def test_loading_reuses_existing_objects(arm, tmp_path):
    _skin, rig = arm
    add_some(rig)
    bpy.data.objects["Biceps"].keyframe_insert("sinew.tissue.tension", frame=1)
    save(rig, tmp_path / "a.json")
    add_muscle(rig, name="Extra")
    load(rig, tmp_path / "a.json", replace_all=False)
    assert "Extra" in bpy.data.objects
    load(rig, tmp_path / "a.json")
    assert "Extra" not in bpy.data.objects and bpy.data.objects["Biceps"].animation_data.action


def test_missing_bones_are_named_and_the_rest_is_loaded(arm, tmp_path, capfd):
    _skin, rig = arm
    add_some(rig)
    save(rig, tmp_path / "a.json")
    text = (tmp_path / "a.json").read_text().replace('{"bone": "lower"', '{"bone": "claw"', 2)
    (tmp_path / "b.json").write_text(text)
    load(rig, tmp_path / "b.json")
    assert 0 < len(characters.tissues_of(rig)) < 5
    assert "claw" in capfd.readouterr().out
