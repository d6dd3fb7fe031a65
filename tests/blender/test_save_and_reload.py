# SPDX-License-Identifier: GPL-3.0-or-later
"""Saving and opening a file, and appending from it."""

import bpy
import numpy as np
from conftest import evaluated_points, save_and_take


def attribute_of(skin):
    values = np.empty(len(skin.data.vertices) * 3, np.float32)
    skin.data.attributes["sinew_correction"].data.foreach_get("vector", values)
    return values


def test_save_and_reload(bent_skin, tmp_path):
    skin, rig = bent_skin
    before, shown = evaluated_points(skin), bpy.data.objects["Muscle lower"].matrix_world.copy()
    path = str(tmp_path / "arm.blend")
    bpy.ops.wm.save_as_mainfile(filepath=path)
    assert np.array_equal(evaluated_points(skin), before)  # saving does not change the display
    bpy.ops.wm.open_mainfile(filepath=path)
    skin = bpy.data.objects["Arm"]
    assert np.array_equal(evaluated_points(skin), before)
    bpy.context.view_layer.update()
    now = bpy.data.objects["Muscle lower"].matrix_world
    assert max(abs(a - b) for x, y in zip(now, shown) for a, b in zip(x, y)) < 1e-6


def test_a_file_holds_nothing_derived(bent_skin, tmp_path):
    """Without Sinew, the mesh of an opened file follows its Armature modifier, without the last correction."""
    skin, _rig = bent_skin
    assert np.abs(attribute_of(skin)).max() > 0
    path = str(tmp_path / "arm.blend")
    bpy.ops.wm.save_as_mainfile(filepath=path)
    bpy.ops.wm.read_factory_settings(use_empty=True)
    with bpy.data.libraries.load(path) as (source, target):
        target.objects = list(source.objects)
    assert np.abs(attribute_of(bpy.data.objects["Arm"])).max() == 0
    assert tuple(bpy.data.objects["Muscle lower"].delta_location) == (0, 0, 0)


def test_append(bent_skin, tmp_path):
    before = evaluated_points(bent_skin[0])
    save_and_take(tmp_path / "arm.blend")
    assert np.array_equal(evaluated_points(bpy.data.objects["Arm"]), before)
