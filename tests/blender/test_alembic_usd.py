# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender's Alembic and USD exporters with the live skin: every frame holds the live points."""

import bpy
import numpy as np
from conftest import evaluated_points, points_over, select

FRAMES = range(1, 13)


def check_imported(live):
    (found,) = [found for found in bpy.data.objects if found.type == "MESH"]
    assert not hasattr(found.data, "sinew_correction") and np.ptp(live, axis=0).max() > 0.1
    for frame in FRAMES:
        bpy.context.scene.frame_set(frame)
        matrix = np.array(found.evaluated_get(bpy.context.evaluated_depsgraph_get()).matrix_world)
        points = evaluated_points(found) @ matrix[:3, :3].T + matrix[:3, 3]
        assert np.abs(points - live[frame - 1]).max() < 1e-6


def test_alembic(waving, tmp_path):
    skin, _rig = waving
    live = points_over(skin, FRAMES)
    bpy.context.scene.frame_set(5)
    select(skin)
    path = str(tmp_path / "arm.abc")
    assert bpy.ops.wm.alembic_export(filepath=path, start=1, end=12, selected=True) == {"FINISHED"}
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.ops.wm.alembic_import(filepath=path, as_background_job=False)
    check_imported(live)


def test_usd_without_armatures(waving, tmp_path):
    """With armatures, Blender writes the rest mesh and a skeleton, which cannot hold the correction."""
    skin, _rig = waving
    live = points_over(skin, FRAMES)
    scene = bpy.context.scene
    scene.frame_start, scene.frame_end = 1, 12
    scene.frame_set(5)
    select(skin)
    path = str(tmp_path / "arm.usdc")
    bpy.ops.wm.usd_export(
        filepath=path, selected_objects_only=True, export_animation=True, export_armatures=False, export_shapekeys=False
    )
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.ops.wm.usd_import(filepath=path)
    check_imported(live)
