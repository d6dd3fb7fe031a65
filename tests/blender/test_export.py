# SPDX-License-Identifier: GPL-3.0-or-later
"""Exports play without Sinew: imported files have the same points, and .blend files open without it."""

import os
from pathlib import Path

import bpy
import numpy as np
import pytest
from conftest import bind, points_over, select
from exports import exported
from test_muscle_bones import bake_bones, copies_of, view_of, waving  # noqa: F401 - waving is a fixture

FRAMES = range(1, 13)
# USD stores bone scales as 16-bit floats, and Blender leaves out scales close to those of the frame before
MOST_MM = {"GLTF": 0.01, "FBX": 0.01, "USD": 2.0, "ALEMBIC": 0.001}


@pytest.fixture
def baked(waving, request):  # noqa: F811
    """(mesh, rig): with muscle bones on an export copy and baked keys of the given kind, over 12 frames."""
    skin, rig = waving
    bpy.context.scene.frame_start, bpy.context.scene.frame_end = 1, 12
    select(skin)
    if request.param == "frames":
        bpy.ops.sinew.bake_shape_keys(frame_start=1, frame_end=12)
    else:
        bpy.ops.sinew.bake_correctives(joints="lower", tolerance=2.0)
    bake_bones(rig)
    return skin, rig


def keys_of(mesh) -> int:
    return len(mesh.data.shape_keys.key_blocks) - 1


@pytest.mark.parametrize("baked", ["frames", "correctives"], indirect=True)
def test_an_imported_export_has_the_same_points(baked, tmp_path):
    skin, rig = baked
    mesh, _rig_copy = copies_of(rig)
    shown = exported.shown(mesh, FRAMES)
    select(rig)
    bpy.context.scene.frame_set(4)
    names = [key.name for key in mesh.data.shape_keys.key_blocks]
    before = view_of(bpy.context), sorted(found.name for found in bpy.data.objects)
    files = []
    for file_format, suffix in exported.SUFFIXES.items():
        assert bpy.ops.sinew.export(filepath=str(tmp_path / "arm"), format=file_format) == {"FINISHED"}
        assert (view_of(bpy.context), sorted(found.name for found in bpy.data.objects)) == before
        assert [key.name for key in mesh.data.shape_keys.key_blocks] == names
        files.append((tmp_path / f"arm{suffix}", shown, None))
    assert sorted(tmp_path.iterdir()) == sorted(file for file, _, _ in files)
    for file_format, back in zip(exported.SUFFIXES, exported.round_trips(files, 1), strict=True):
        assert back.max_mm < MOST_MM[file_format] and back.missing == 0 and back.contents["unknown"] == [], file_format
        if file_format != "ALEMBIC":
            assert (back.contents["keys"], back.contents["muscle bones"]) == (keys_of(mesh), 3)
            assert back.contents["drivers"] == 0 < back.contents["key curves"]
            assert back.contents["bone curves"] > 0 and back.contents["most influences"] <= 4


def test_keys_are_exported_without_muscle_bones_too(waving, tmp_path):  # noqa: F811
    skin, rig = waving
    bpy.context.scene.frame_start, bpy.context.scene.frame_end = 1, 12
    select(skin)
    bpy.ops.sinew.bake_shape_keys(frame_start=1, frame_end=12)
    shown = exported.shown(skin, FRAMES)
    skin.sinew.skin.live = True
    bpy.ops.sinew.export(filepath=str(tmp_path / "arm.glb"))
    assert skin.sinew.skin.live
    (back,) = exported.round_trips([(tmp_path / "arm.glb", shown, None)], 1)
    assert back.max_mm < 0.01 and back.contents["keys"] == keys_of(skin)


def test_alembic_holds_the_live_skin(waving, tmp_path):  # noqa: F811
    skin, _rig = waving
    bpy.context.scene.frame_start, bpy.context.scene.frame_end = 1, 12
    shown = exported.shown(skin, FRAMES)
    select(skin)
    bpy.ops.sinew.export(filepath=str(tmp_path / "arm.abc"), format="ALEMBIC")
    assert exported.round_trips([(tmp_path / "arm.abc", shown, None)], 1)[0].max_mm < 0.001


@pytest.mark.parametrize("baked", ["frames", "correctives"], indirect=True)
def test_a_baked_file_plays_without_sinew(baked, tmp_path):
    """The keys are on the character and the muscle bones on its copy. Shaded muscles and other display do no harm."""
    skin, rig = baked
    rig.sinew.rig.show_shaded = rig.sinew.rig.show_attachments = True
    skin.sinew.skin.live = False
    mesh, _rig_copy = copies_of(rig)
    meshes = [(found.name, exported.shown(found, FRAMES)) for found in (skin, mesh)]
    file = tmp_path / "arm.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(file))
    for back in exported.round_trips([(file, points, name) for name, points in meshes], 1):
        assert back.max_mm < 1e-3 and back.missing == 0 and back.contents["unknown"] == []
        assert [line for line in back.log.splitlines() if "Read blend" not in line and line.strip()] == []


def test_a_live_file_without_sinew_shows_the_armature_modifier(waving, tmp_path):  # noqa: F811
    skin, rig = waving
    rig.sinew.rig.show_shaded = True
    skin.modifiers["Sinew"].show_viewport = False
    bare = exported.shown(skin, FRAMES)
    skin.modifiers["Sinew"].show_viewport = True
    file = tmp_path / "arm.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(file))
    (back,) = exported.round_trips([(file, bare, "Arm")], 1)
    assert back.max_mm < 1e-3 and back.contents["unknown"] == []


def export(**settings):
    with pytest.raises(RuntimeError) as caught:
        bpy.ops.sinew.export(**settings)
    return str(caught.value)


def test_a_live_skin_without_bake_is_refused_for_gltf(waving, tmp_path):  # noqa: F811
    _skin, rig = waving
    select(rig)
    assert "Arm Rig has no baked data" in export(filepath=str(tmp_path / "arm.glb"))
    assert list(tmp_path.iterdir()) == []


def test_an_unbound_mesh_is_not_exported(arm, tmp_path):
    skin, _rig = arm
    select(skin)
    assert "no bound mesh" in export(filepath=str(tmp_path / "arm.glb"))


@pytest.mark.parametrize("file_format", MOST_MM)
def test_a_missing_folder_is_reported(waving, file_format, tmp_path):  # noqa: F811
    _skin, rig = waving
    bake_bones(rig)
    select(rig)
    assert "There is no folder" in export(filepath=str(tmp_path / "none" / "arm"), format=file_format)


def test_a_folder_with_the_files_name_is_reported_and_kept(waving, tmp_path):  # noqa: F811
    _skin, rig = waving
    bake_bones(rig)
    select(rig)
    (tmp_path / "arm.glb").mkdir()
    assert "is a folder" in export(filepath=str(tmp_path / "arm.glb"))
    assert [found.name for found in tmp_path.iterdir()] == ["arm.glb"]


@pytest.mark.skipif(not Path("/proc").is_dir(), reason="only here is a folder known that nobody can write to")
@pytest.mark.parametrize("file_format", MOST_MM)
def test_a_read_only_folder_is_reported(waving, file_format):  # noqa: F811
    _skin, rig = waving
    bake_bones(rig)
    select(rig)
    assert "written" in export(filepath=f"/proc/{os.getpid()}/arm", format=file_format)


def test_a_hidden_mesh_is_reported(waving, tmp_path):  # noqa: F811
    skin, rig = waving
    select(skin)
    bpy.ops.sinew.bake_shape_keys(frame_start=1, frame_end=12)
    select(rig)
    skin.hide_set(True)
    assert "Hidden objects are not exported: " in export(filepath=str(tmp_path / "arm.glb"))


def test_a_deleted_armature_of_the_copy_is_reported(waving, tmp_path):  # noqa: F811
    skin, rig = waving
    bake_bones(rig)
    bpy.data.objects.remove(bpy.data.objects["Arm Rig Export"])
    select(rig)
    assert "deleted" in export(filepath=str(tmp_path / "arm.glb"))
    select(skin)
    bind(skin)
    assert np.isfinite(points_over(skin, (1, 12))).all()
