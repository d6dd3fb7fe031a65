# SPDX-License-Identifier: GPL-3.0-or-later
"""The presets of a user: saved, loaded on another character, renamed and deleted, in a folder of their own."""

import bpy
import pytest
from bl_ext.user_default.sinew.files import user_folder
from bl_ext.user_default.sinew.muscles import user_presets
from bl_ext.user_default.sinew.scene import characters
from conftest import add_muscle, make_arm, select


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    """A folder of presets for each test."""
    monkeypatch.setattr(user_folder, "folder", lambda _name: tmp_path)
    return tmp_path


def names():
    return [identifier for identifier, _label, _description in user_presets.available()]


def save(rig, name, **settings):
    select(rig)
    bpy.ops.sinew.save_preset(name=name, **settings)


def test_a_preset_is_loaded_on_another_character(arm, folder):
    _skin, rig = arm
    add_muscle(rig, name="Biceps")
    save(rig, "Strong arm")
    assert names() == ["Strong arm"] and [path.name for path in folder.iterdir()] == ["Strong arm.json"]
    _other_skin, other = make_arm("Other")
    select(other)
    bpy.ops.sinew.load_preset(preset="Strong arm")
    assert len(characters.tissues_of(other)) == 1


def test_a_preset_is_replaced_only_on_request(arm, folder):
    _skin, rig = arm
    add_muscle(rig, name="A")
    save(rig, "Mine")
    before = (folder / "Mine.json").read_bytes()
    add_muscle(rig, name="B")
    with pytest.raises(RuntimeError, match="a preset 'Mine' already"):
        save(rig, "Mine")
    assert (folder / "Mine.json").read_bytes() == before
    save(rig, "Mine", replace=True)
    assert (folder / "Mine.json").read_bytes() != before


def test_presets_are_renamed_and_deleted(arm):
    _skin, rig = arm
    add_muscle(rig, name="A")
    for name in ("One", "Two"):
        save(rig, name)
    with pytest.raises(RuntimeError, match="a preset 'Two' already"):
        bpy.ops.sinew.rename_preset(preset="One", name="Two")
    bpy.ops.sinew.rename_preset(preset="One", name="Three")
    assert names() == ["Three", "Two"]
    bpy.ops.sinew.delete_preset(preset="Two")
    assert names() == ["Three"]


@pytest.mark.parametrize("name", ["../escape", "a/b", "CON", ".hidden", "Übung 1", "x" * 300])
def test_every_name_is_a_file_in_the_folder(arm, folder, name):
    _skin, rig = arm
    add_muscle(rig, name="A")
    save(rig, name)
    (path,) = folder.iterdir()
    assert path.parent == folder and len(names()) == 1


def test_a_preset_needs_a_name(arm):
    _skin, rig = arm
    add_muscle(rig, name="A")
    with pytest.raises(RuntimeError, match="has no name"):
        save(rig, "  ")


def test_without_presets_the_operators_say_how_to_make_one(arm):
    _skin, rig = arm
    select(rig)
    for operator in (bpy.ops.sinew.rename_preset, bpy.ops.sinew.delete_preset):
        with pytest.raises(RuntimeError, match="Save as Preset"):
            operator()
    with pytest.raises(RuntimeError, match="Save as Preset"):
        bpy.ops.sinew.load_preset()


def test_a_broken_file_is_refused(arm, folder):
    _skin, rig = arm
    (folder / "Bad.json").write_text("{")
    select(rig)
    with pytest.raises(RuntimeError, match="Bad.json"):
        bpy.ops.sinew.load_preset(preset="Bad")
