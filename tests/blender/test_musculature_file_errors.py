# SPDX-License-Identifier: GPL-3.0-or-later
"""Wrong and missing musculature files: each is reported with its line and field, and the rig keeps its tissues."""

import json

import bpy
import pytest
from bl_ext.user_default.sinew.scene import characters
from conftest import add_muscle, select
from test_musculature_file import load, save

pytestmark = pytest.mark.one_blender

WRONG = (
    ("not json", "{,}", r"line 1: not JSON"),
    ("no object", "[1]", r"line 1: must be an object"),
    ("another format", '{\n"sinew_musculature": 3,\n"rig": "", "tissues": []}',
        r"line 2: 'sinew_musculature' must be 1 or 2"),
    ("no tissues", '{"sinew_musculature": 1,\n"rig": ""}', r"line 1: 'tissues' is missing"),
    ("a list of numbers", '{"sinew_musculature": 1,\n"rig": "",\n"tissues": [1]}',
        r"line 3: 'tissues' must be a list of objects"),
    ("twins", '{"sinew_musculature": 1,\n"rig": "",\n"rig": "", "tissues": []}', r"line 3: 'rig' appears twice"),
    ("stranger", '{"sinew_musculature": 1, "rig": "",\n"run": "rm", "tissues": []}', r"line 2: 'run' is not a field"),
)  # fmt: skip


@pytest.mark.parametrize(("name", "text", "words"), WRONG, ids=[name for name, _, _ in WRONG])
def test_a_wrong_file_is_reported_with_line_and_field(arm, tmp_path, name, text, words):
    refused(arm[1], tmp_path / "wrong.json", text, "wrong.json, " + words)


def refused(rig, path, text, words):
    add_muscle(rig)
    path.write_text(text)
    with pytest.raises(RuntimeError, match=words):
        load(rig, path)
    assert [empty.name for empty in characters.tissues_of(rig)] == ["Muscle lower"]


@pytest.mark.parametrize(
    ("field", "value"),
    [
        ("kind", '"MUSCLES"'),
        ("name", '""'),
        ("name", f'"{"x" * 70}"'),
        ("widths", "[0.1]"),
        ("widths", "[0.1, NaN]"),
        ("widths", "[0.1, -1]"),
        ("twist", "1e9"),
        ("tendons", "[0.6, 0.6]"),
        ("tension", "\"__import__('os')\""),
        ("volume_keeping", "true"),
    ],
)
def test_a_wrong_field_is_reported_with_its_line(arm, tmp_path, field, value):
    _skin, rig = arm
    add_muscle(rig)
    lines = save(rig, tmp_path / "a.json").decode().splitlines()
    number = next(number for number, line in enumerate(lines) if f'"{field}"' in line)
    head, tail = lines[number].split(f'"{field}": ')
    old, _end = json.JSONDecoder().raw_decode(tail)
    rest = tail[len(json.dumps(old)) :]
    lines[number] = f'{head}"{field}": {value}{rest}'
    words = rf"wrong.json, line {number + 1}: (Muscle lower: )?'(tissues\.)?{field}'"
    refused(rig, tmp_path / "wrong.json", "\n".join(lines), words)


def test_a_missing_file(arm, tmp_path):
    _skin, rig = arm
    select(rig)
    with pytest.raises(RuntimeError, match="nothing.json: can't be read"):
        bpy.ops.sinew.load_musculature(filepath=str(tmp_path / "nothing.json"))
    with pytest.raises(RuntimeError, match="has no muscles"):
        bpy.ops.sinew.save_musculature(filepath=str(tmp_path / "a.json"))
    add_muscle(rig)
    select(rig)
    with pytest.raises(RuntimeError, match="could not be written"):
        bpy.ops.sinew.save_musculature(filepath=str(tmp_path / "no folder" / "a.json"))


@pytest.mark.parametrize(
    ("spoil", "words"),
    [
        (lambda rig: rename(rig, "x" * 60), "Tissue .*is longer than 58 bytes"),
        (lambda rig: rename(rig, "two\nlines"), "Tissue .*must be a text"),
        (lambda rig: setattr(rig.data.bones["upper"], "name", " "), "Bone .*must be a text"),
        (lambda rig: stretch(rig, 1e9), "was not written, line .*'widths' must have numbers"),
    ],
)
def test_nothing_is_saved_that_could_not_be_loaded(arm, tmp_path, spoil, words):
    _skin, rig = arm
    add_muscle(rig)
    path = tmp_path / "a.json"
    before = save(rig, path)
    spoil(rig)
    bpy.context.view_layer.update()
    with pytest.raises(RuntimeError, match=words):
        save(rig, path)
    assert path.read_bytes() == before and [found.name for found in tmp_path.iterdir()] == ["a.json"]


def rename(rig, name):
    characters.tissues_of(rig)[0].name = name


def stretch(rig, factor):
    characters.tissues_of(rig)[0].scale.x *= factor
