# SPDX-License-Identifier: GPL-3.0-or-later
"""Sinew writes nothing into its own folder (a rule of the extensions platform)."""

from pathlib import Path

import bpy
from bl_ext.user_default import sinew
from conftest import add_muscle, select

FOLDER = Path(sinew.__file__).parent


def contents():
    """Size and time of every file in the add-on's folder, without what Python itself writes."""
    files = (path for path in FOLDER.rglob("*") if path.is_file() and "__pycache__" not in path.parts)
    return {path: (path.stat().st_size, path.stat().st_mtime_ns) for path in files}


def test_a_session_writes_only_where_the_user_chose(arm, tmp_path):
    before = contents()
    skin, rig = arm
    add_muscle(rig)
    select(skin)
    assert bpy.ops.sinew.bind() == {"FINISHED"}
    assert bpy.ops.sinew.measure(poses="CURRENT", filepath=str(tmp_path / "quality.json")) == {"FINISHED"}
    assert bpy.ops.sinew.bake_cache(frame_start=1, frame_end=2, folder=str(tmp_path), attach=False) == {"FINISHED"}
    select(rig)
    assert bpy.ops.sinew.save_musculature(filepath=str(tmp_path / "arm.json")) == {"FINISHED"}
    assert contents() == before
    assert {path.suffix for path in tmp_path.iterdir()} == {".json", ".pc2"}
