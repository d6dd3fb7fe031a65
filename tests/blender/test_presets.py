# SPDX-License-Identifier: GPL-3.0-or-later
"""The shipped presets on common rigs, adding a preset with one click, and errors in preset files."""

import json
import time
from collections import Counter

import bpy
import pytest
from bl_ext.user_default.sinew.errors import SinewError
from bl_ext.user_default.sinew.muscles.placing.fit import fit
from bl_ext.user_default.sinew.muscles.placing.fit.skin_surface import SkinSurface
from bl_ext.user_default.sinew.muscles.placing.place import placement, preset_file
from bl_ext.user_default.sinew.muscles.placing.recognise import segments
from bl_ext.user_default.sinew.scene import characters
from conftest import delete_in_viewport, problems_of, select, tissue_names
from test_preset_placement import assert_mirrored, asymmetry_m

pytestmark = pytest.mark.one_blender

COUNTS = {
    "human": {"MUSCLE": 252, "BONE": 77, "STUFFING": 218, "SPHERE": 12},
    "limbs": {"MUSCLE": 58, "SPHERE": 12},
    "myo": {"MUSCLE": 416},
    "cat": {"MUSCLE": 128, "BONE": 39, "STUFFING": 13},
    "hand": {"MUSCLE": 58, "BONE": 54, "STUFFING": 36},
    "toad": {"MUSCLE": 122, "BONE": 36, "STUFFING": 13},
}
MYO_JOINED = 206
FOR_A_HUMAN = ("human", "limbs", "myo", "hand")


def counted(shapes):
    return dict(Counter(shape.kind for shape in shapes))


def placed(name, rig, skin=None, strands=placement.SEPARATE):
    shapes = placement.place(preset_file.read(name), segments.recognise(rig), skin, strands)
    return fit.fit_all(shapes, skin) if skin else shapes


@pytest.fixture
def metarig(rigify):
    """Makes a metarig of Rigify by its name."""

    def made(kind):
        getattr(bpy.ops.object, f"armature_{kind}_metarig_add")()
        return bpy.context.object

    return made


# Bodies


@pytest.mark.parametrize("name", FOR_A_HUMAN)
def test_a_preset_on_the_human_metarig(metarig, name):
    rig = metarig("human")
    shapes = placed(name, rig)
    assert counted(shapes) == COUNTS[name]
    assert_mirrored(shapes, 1e-5 + 2 * asymmetry_m(rig), 1e-3 + 100 * asymmetry_m(rig))


@pytest.mark.parametrize("name", FOR_A_HUMAN)
def test_a_preset_on_the_real_body(real_body, name):
    mesh, rig = real_body
    skin = SkinSurface.of(mesh, rig)
    shapes = placed(name, rig, skin)
    assert counted(shapes) == COUNTS[name]
    assert_mirrored(shapes, 1e-5)
    farthest_m, farthest = max((fit.protrusion(shape, skin), shape.name) for shape in shapes)
    print(f"{name}: farthest out of the skin {farthest_m * 1000:.3f} mm ({farthest})")
    assert farthest_m < 1e-5, farthest


def test_the_cat(metarig):
    rig = metarig("cat")
    shapes = placed("cat", rig)
    assert counted(shapes) == COUNTS["cat"]
    assert_mirrored(shapes, 1e-5)
    assert len(segments.recognise(rig).segments) == 27


def test_the_cat_preset_is_refused_on_a_human(real_body):
    _, rig = real_body
    preset, body = preset_file.read("cat"), segments.recognise(rig)
    left_out = placement.left_out(preset, body)
    assert set(left_out) == {"tail base", "tail middle", "tail tip"}
    assert len(placement.place(preset, body, None)) == 180 - len({name for names in left_out.values() for name in names})


def test_strands_are_joined_to_bellies(real_body):
    mesh, rig = real_body
    skin = SkinSurface.of(mesh, rig)
    shapes = placed("myo", rig, skin, placement.JOINED)
    names = {shape.name for shape in shapes}
    assert len(shapes) == len(names) == MYO_JOINED
    assert {"Multifidus.L", "Psoas major.R", "Extensor digitorum.L"} < names
    assert_mirrored(shapes, 1e-5)
    assert max(fit.protrusion(shape, skin) for shape in shapes) < 1e-5


def test_wraps_name_spheres_and_via_points_bones_of_the_rig(real_body):
    _, rig = real_body
    shapes = placed("human", rig)
    spheres = {shape.name for shape in shapes if shape.kind == "SPHERE"}
    wrapped = [shape for shape in shapes if shape.wraps]
    assert len(wrapped) > 10
    assert all(wrap in spheres for shape in wrapped for wrap in shape.wraps)
    assert all(bone in rig.data.bones for shape in shapes for bone, _ in shape.via_points)
    sartorius = next(shape for shape in shapes if shape.name == "Sartorius.L")
    assert len(sartorius.via_points) == 1


@pytest.mark.parametrize("name", ["human", "myo"])
def test_via_points_are_outside_the_belly(real_body, name):
    mesh, rig = real_body
    skin = SkinSurface.of(mesh, rig)
    curved = [shape for shape in placed(name, rig, skin) if shape.via_points]
    assert curved
    for shape in curved:
        for _, point in shape.via_points:
            assert skin.is_inside(point), shape.name


# One click


def test_one_click_on_the_real_body(real_body):
    _, rig = real_body
    select(rig)
    begin_s = time.perf_counter()
    bpy.ops.sinew.add_preset(name="human")
    print(f"one click, human on {len(bpy.data.meshes['Body'].vertices)} vertices: {time.perf_counter() - begin_s:.3f} s")
    added = Counter(found.sinew.tissue.kind for found in bpy.data.objects)
    solid = ("MUSCLE", "BONE", "SPHERE")
    assert {kind: added[kind] for kind in solid} == {kind: COUNTS["human"][kind] for kind in solid}
    assert 0 < added["STUFFING"] <= COUNTS["human"]["STUFFING"]  # without what there is no room for


def test_the_menu_opens_no_dialog_if_the_guess_is_good(metarig):
    select(metarig("human"))
    assert bpy.ops.sinew.add_preset("INVOKE_DEFAULT", name="human") == {"FINISHED"}
    assert sum(found.sinew.tissue.kind == "MUSCLE" for found in bpy.data.objects) == COUNTS["human"]["MUSCLE"]


def test_adding_twice_replaces(metarig):
    select(metarig("human"))
    for _ in range(2):
        bpy.ops.sinew.add_preset(name="limbs")
    assert sum(found.sinew.tissue.kind != "NONE" for found in bpy.data.objects) == sum(COUNTS["limbs"].values())


def test_a_wrong_guess_is_corrected_by_a_script(metarig):
    rig = metarig("human")
    rig.data.bones["forearm.L"].name = "strange"
    select(rig)
    with pytest.raises(RuntimeError, match="forearm L is missing"):
        bpy.ops.sinew.add_preset(name="limbs")
    bpy.ops.sinew.add_preset(name="limbs", bones=[{"name": "", "role": "forearm", "side": "L", "bone": "strange"}])
    assert bpy.data.objects["Brachioradialis.L"].sinew.tissue.insertion_bone == "strange"


def test_a_correction_to_no_bone_is_an_error(metarig):
    select(metarig("human"))
    with pytest.raises(RuntimeError, match="has no such bone"):
        bpy.ops.sinew.add_preset(name="limbs", bones=[{"name": "", "role": "thigh", "side": "R", "bone": "leg"}])


# Files


def limbs_data():
    return json.loads((preset_file.FOLDER / "limbs.json").read_text(encoding="utf-8"))


def written(tmp_path, data):
    path = tmp_path / "mine.json"
    path.write_text(data if isinstance(data, str) else json.dumps(data, indent=1), encoding="utf-8")
    return path


def test_shipped_presets_are_listed():
    listed = preset_file.available()
    assert [identifier for identifier, _, _ in listed] == [
        "human", "bird", "cat", "fish", "hand", "limbs", "myo", "quadruped", "toad"
    ]  # fmt: skip
    assert all(description for _, _, description in listed)


@pytest.mark.parametrize("name", COUNTS)
def test_every_group_has_a_source(name):
    preset = preset_file.read(name)
    assert {tissue.group for tissue in preset.tissues} == set(preset.sources)


def test_a_users_file_is_read(tmp_path):
    assert preset_file.read(written(tmp_path, limbs_data())) == preset_file.read("limbs")


def test_an_unknown_preset_is_refused_with_the_known_names():
    with pytest.raises(SinewError, match="no preset 'dragon'.*human, bird, cat, fish, hand, limbs, myo, quadruped, toad"):
        preset_file.read("dragon")


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda data: data.update(sinew_preset=2), "'sinew_preset' must be"),
        (lambda data: data.pop("sources"), "'sources' is missing"),
        (lambda data: data.update(tissues=[]), "'tissues' has 0 entries; it must have 1 or more"),
        (lambda data: data.update(author="me"), "'author' is not a field"),
        (lambda data: data.update(sources={}), "'sources' must name"),
        (lambda data: data["tissues"][3].update(kind="BONY"), "Biceps brachii: 'kind' must be one of"),
        (lambda data: data["tissues"][3].update(group="tail"), "Biceps brachii: 'group' must be one of"),
        (lambda data: data["tissues"][3].update(sides=["R", "L"]), "Biceps brachii: 'sides' must be one of"),
        (lambda data: data["tissues"][3].update(sides="L"), "Biceps brachii: 'sides' must be"),
        (
            lambda data: data["tissues"][3]["origin"].update(depth=1.5),
            "Biceps brachii: 'origin.depth' must be .* 0 to 1, not 1.5",
        ),
        (lambda data: data["tissues"][3]["origin"].update(depth=True), "Biceps brachii: 'origin.depth' must be a number"),
        (
            lambda data: data["tissues"][3]["origin"].update(along=1e300),
            "Biceps brachii: 'origin.along' must be .* -3 to 3",
        ),
        (lambda data: data["tissues"][3]["insertion"].update(segment="wing"), "Biceps brachii: 'insertion.segment'"),
        (lambda data: data["tissues"][3]["insertion"].pop("around"), "Biceps brachii: 'insertion.around' is missing"),
        (lambda data: data["tissues"][3].update(origin_tendon=0.8), "Biceps brachii: 'insertion_tendon' .* no belly"),
        (lambda data: data["tissues"][3].update(width_ratio="wide"), "Biceps brachii: 'width_ratio' must be a number"),
        (
            lambda data: data["tissues"][3].update(wraps=["Globe"]),
            "Biceps brachii: 'wraps' names 'Globe', which is not",
        ),
        (lambda data: data["tissues"][3].update(name=""), "tissue 4: 'name' must be a text"),
        (lambda data: data["tissues"][3].update(name="x" * 99), "'name' is longer"),
        (lambda data: data["tissues"][3].update(name="Brachialis"), "Brachialis: 'name' is used twice: tissues 4 and 5"),
        (lambda data: data["tissues"].__setitem__(3, 7), "'tissues' must be a list of objects in braces; entry 4 is 7"),
        (lambda data: data["tissues"][-1].update(joint="jaw"), "Ankle joint: 'joint' must be one of"),
        (lambda data: data["tissues"][-1].update(script="import os"), "Ankle joint: 'script' is not a field"),
    ],
)
def test_a_wrong_field_is_named(tmp_path, change, message):
    data = limbs_data()
    change(data)
    with pytest.raises(SinewError, match=rf"mine\.json, line \d+: .*{message}"):
        preset_file.read(written(tmp_path, data))


def schema_cases():
    """(a tissue of each kind, the keys to a value in it, a wrong value): what schema.json says of numbers and choices."""
    definitions = json.loads(preset_file.SCHEMA.read_text(encoding="utf-8"))["definitions"]
    attachment = definitions["attachment"]["properties"]
    for kind in ("muscle", "bone", "stuffing", "sphere"):
        properties = dict(definitions["tissue"]["properties"])
        properties |= {name: rule for name, rule in definitions[kind]["properties"].items() if rule}
        at = {("origin", name): rule for name, rule in attachment.items()} if "origin" in properties else {}
        for keys, rule in ({(name,): rule for name, rule in properties.items()} | at).items():
            rule = definitions[rule["$ref"].rpartition("/")[2]] if "$ref" in rule else rule
            for bound, step in (("minimum", -0.01), ("maximum", 0.01)):
                if bound in rule:
                    yield kind.upper(), keys, rule[bound] + step
            if "enum" in rule:
                yield kind.upper(), keys, "SOMETHING"
        for name in [*definitions["tissue"]["required"], *definitions[kind]["required"]]:
            yield kind.upper(), (name,), None
        yield kind.upper(), ("unknown",), 1


@pytest.mark.parametrize(("kind", "keys", "value"), list(schema_cases()))
def test_values_outside_the_schema_are_refused(tmp_path, kind, keys, value):
    data = json.loads((preset_file.FOLDER / "human.json").read_text(encoding="utf-8"))
    tissue = next(tissue for tissue in data["tissues"] if tissue["kind"] == kind)
    data["tissues"] = [tissue]
    tissue.pop("wraps", None)
    preset_file.read(written(tmp_path, data))
    *above, last = keys
    for key in above:
        tissue = tissue[key]
    if value is None:
        del tissue[last]
    else:
        tissue[last] = value
    with pytest.raises(SinewError, match=rf"mine\.json, line \d+: .*'{'.'.join(keys)}'"):
        preset_file.read(written(tmp_path, data))


def test_an_object_with_very_many_fields_is_refused_in_time(tmp_path):
    """Checking for repeated names must take linear time: a quadratic check took hours."""
    fields = ",".join(f'"field {index}": 0' for index in range(200_000))
    with pytest.raises(SinewError, match="more than 1000 fields"):
        preset_file.read(written(tmp_path, f"{{{fields}}}"))


def test_a_message_names_the_line_of_its_field(tmp_path):
    data = limbs_data()
    data["tissues"][3]["insertion"]["depth"] = -2
    path = written(tmp_path, data)
    line = 1 + next(i for i, text in enumerate(path.read_text().splitlines()) if '"depth": -2' in text)
    with pytest.raises(SinewError, match=rf"line {line}: Biceps brachii: 'insertion.depth' must be .* 0 to 1, not -2"):
        preset_file.read(path)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ('{"sinew_preset": 1,\n "name" }', "line 2: not JSON"),
        ("", "line 1: not JSON"),
        ("[]", "line 1: must be an object in braces"),
        ('{"name": 1,\n "name": 2}', "line 2: 'name' appears twice"),
        ('{"sinew_preset":\n NaN}', "line 2: 'sinew_preset' has NaN, which is not a number"),
        ('{"sinew_preset": -Infinity}', "line 1: 'sinew_preset' has -Infinity"),
        ('{"sinew_preset":\n 1e999}', "line 2: 'sinew_preset' has 1e999, which is too large"),
        ("[" * 100_000, "more than 8 objects and lists inside each other"),
        ('{"name": [' + "[]," * 1_000_000 + "[]]}", "more than 250000 values"),
        ('{"sinew_preset": "\\ud800"}', "line 1: not JSON"),
        ('{"name": 1}\n}', "line 2: not JSON"),
    ],
)
def test_a_file_that_is_not_a_preset_is_reported(tmp_path, text, message):
    with pytest.raises(SinewError, match=message):
        preset_file.read(written(tmp_path, text))


def test_a_missing_file_or_a_file_that_is_not_text(tmp_path):
    with pytest.raises(SinewError, match=r"gone\.json: can't be read"):
        preset_file.read(tmp_path / "gone.json")
    (tmp_path / "bytes.json").write_bytes(b"\xff\xfe\x00")
    with pytest.raises(SinewError, match=r"bytes\.json: not a JSON file in UTF-8"):
        preset_file.read(tmp_path / "bytes.json")


def test_a_huge_file(tmp_path):
    with pytest.raises(SinewError, match="too large"):
        preset_file.read(written(tmp_path, " " * (preset_file.LARGEST_FILE_BYTES + 1)))


def test_the_number_of_added_tissues_is_reported(human, capfd):
    bpy.ops.sinew.add_preset(name="human")
    assert "252 muscles and 307 other tissues added to metarig" in capfd.readouterr().out


def test_a_preset_restores_a_deleted_muscle_with_its_name(human):
    before = tissue_names(human)
    delete_in_viewport("Sartorius.R")
    select(human)
    bpy.ops.sinew.add_preset(name="human")
    assert tissue_names(human) == before


def test_the_cat_preset_on_a_horse(rigify, capfd):
    bpy.ops.object.armature_horse_metarig_add()
    horse = bpy.context.object
    bpy.ops.sinew.add_preset(name="cat")
    assert "(Rigify horse)" in capfd.readouterr().out
    muscles = [empty for empty in characters.tissues_of(horse) if empty.sinew.tissue.kind == "MUSCLE"]
    assert len(muscles) == 128
    assert not problems_of(horse)
