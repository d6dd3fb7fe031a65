# SPDX-License-Identifier: GPL-3.0-or-later
"""Presets as assets: the library that the Asset Browser shows, and what a drop on a character does."""

import bpy
import pytest
from bl_ext.user_default.sinew.files import user_folder
from bl_ext.user_default.sinew.live import handlers
from bl_ext.user_default.sinew.muscles import preset_assets
from bl_ext.user_default.sinew.operators import preset_items
from bl_ext.user_default.sinew.scene import characters
from bl_ext.user_default.sinew.settings import updates
from conftest import add_muscle, make_arm, select


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    """A user folder for each test."""

    def folder_of(name):
        (tmp_path / name).mkdir(exist_ok=True)
        return tmp_path / name

    monkeypatch.setattr(user_folder, "folder", folder_of)
    yield tmp_path
    libraries = bpy.context.preferences.filepaths.asset_libraries
    for library in [library for library in libraries if library.name == preset_assets.LIBRARY]:
        libraries.remove(library)


def dropped(preset, at=(0.0, 0.0, 0.0)):
    """An asset's Empty in the scene, as Blender's drop adds it."""
    empty = bpy.data.objects.new("Dropped", None)
    empty[preset_assets.PROPERTY] = preset
    empty.location = at
    bpy.context.scene.collection.objects.link(empty)
    bpy.context.view_layer.update()
    return empty


def in_library(folder):
    with bpy.data.libraries.load(str(folder / "assets" / preset_assets.FILE), assets_only=True) as (held, _wanted):
        return set(held.objects)


def test_the_library_holds_all_presets_with_pictures(arm, folder):
    _skin, rig = arm
    add_muscle(rig, name="Biceps")
    select(rig)
    bpy.ops.sinew.save_preset(name="Mine")
    before = set(bpy.data.objects), set(bpy.data.images)
    assert bpy.ops.sinew.make_assets() == {"FINISHED"} and bpy.ops.sinew.make_assets() == {"FINISHED"}
    assert (set(bpy.data.objects), set(bpy.data.images)) == before
    labels = {asset.label for asset in preset_assets.all_presets()}
    assert in_library(folder) == labels and {"Human", "Mine"} <= labels
    assert all(asset.picture.is_file() for asset in preset_assets.all_presets() if asset.label != "Mine")
    libraries = bpy.context.preferences.filepaths.asset_libraries
    assert [library.name for library in libraries].count(preset_assets.LIBRARY) == 1


def test_the_library_follows_the_users_presets(arm, folder):
    _skin, rig = arm
    add_muscle(rig, name="Biceps")
    select(rig)
    bpy.ops.sinew.make_assets()
    bpy.ops.sinew.save_preset(name="Mine")
    assert "Mine" in in_library(folder)
    bpy.ops.sinew.rename_preset(preset="Mine", name="Yours")
    assert "Yours" in in_library(folder) and "Mine" not in in_library(folder)
    bpy.ops.sinew.delete_preset(preset="Yours")
    assert "Yours" not in in_library(folder)


def test_a_drop_adds_the_preset_to_the_nearest_character(arm):
    _skin, rig = arm
    add_muscle(rig, name="Biceps")
    select(rig)
    bpy.ops.sinew.save_preset(name="Mine")
    _other_skin, other = make_arm("Other")
    other.location = (0.0, 3.0, 0.0)
    bpy.context.view_layer.update()
    dropped("user:Mine", (0.1, 3.0, 0.05))
    assert bpy.ops.sinew.drop_preset() == {"FINISHED"}
    assert len(characters.tissues_of(other)) == 1 and bpy.context.object == other
    assert not any(preset_assets.PROPERTY in found for found in bpy.data.objects)


@pytest.mark.parametrize(("preset", "at", "problem"), [
    ("human", (0.0, 9.0, 0.0), "no character under the mouse"),
    ("user:Gone", (0.1, 0.0, 0.05), "no preset 'Gone'"),
])  # fmt: skip
def test_a_drop_that_fails_leaves_no_asset_in_the_scene(arm, preset, at, problem):
    dropped(preset, at)
    with pytest.raises(RuntimeError, match=problem):
        bpy.ops.sinew.drop_preset()
    assert not any(preset_assets.PROPERTY in found for found in bpy.data.objects)


def test_a_drop_is_noticed_once_and_an_undo_is_not_a_drop(arm, monkeypatch):
    noticed = []
    monkeypatch.setattr(updates, "on_preset_dropped", [lambda: noticed.append(1)])
    empty = dropped("human")
    assert noticed
    noticed.clear()
    handlers.mark_all_dirty()  # as after an undo
    empty.update_tag()
    bpy.context.view_layer.update()
    assert not noticed


def test_presets_have_icons():
    items = preset_items.shipped()
    assert items is preset_items.shipped() and all(len(item) == 5 for item in items)
