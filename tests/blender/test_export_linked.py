# SPDX-License-Identifier: GPL-3.0-or-later
"""Exports of linked characters, and of a user's own driven keys beside correctives."""

import bpy
import numpy as np
from conftest import link_character, points_over, rest_points, save_character
from exports import exported
from test_export_whole import FRAMES, bake_correctives, contents_of, files_of
from test_muscle_bones import bake_bones, waving  # noqa: F401 - waving is a fixture


def add_own_key(skin, rig, metres):
    """A key of the user's, driven by the elbow's rotation, that moves the skin around the elbow along Y."""
    skin.shape_key_add(name="Basis", from_mix=False) if skin.data.shape_keys is None else None
    points = rest_points(skin)
    points[:, 1] += metres * np.exp(-((points[:, 0] - 0.3) ** 2) / 0.005)
    key = skin.shape_key_add(name="mine", from_mix=False)
    key.points.foreach_set("co", points.astype(np.float32).reshape(-1))
    driver = key.driver_add("value").driver
    driver.type, driver.expression = "SCRIPTED", "bend/1.4"
    variable = driver.variables.new()
    variable.name, variable.type = "bend", "TRANSFORMS"
    target = variable.targets[0]
    target.id, target.bone_target = rig, "lower"
    target.transform_type, target.transform_space, target.rotation_mode = "ROT_Z", "LOCAL_SPACE", "SWING_TWIST_Y"
    return key


def test_a_linked_character_has_a_curve_for_each_key(waving, tmp_path):  # noqa: F811
    skin, rig = waving
    bake_correctives(skin)
    add_own_key(skin, rig, 0.01)
    keys = len(skin.data.shape_keys.key_blocks) - 1
    path = str(tmp_path / "character.blend")
    save_character(path)
    skin, rig = link_character(path)
    bpy.context.scene.frame_start, bpy.context.scene.frame_end = 1, 12
    assert skin.override_library is not None and rig.override_library is not None
    skin.sinew.skin.live = False
    names = [(found.name, found.library is None) for found in bpy.data.objects]
    files = files_of(rig, exported.shown(skin, FRAMES), tmp_path, "linked")
    assert [(found.name, found.library is None) for found in bpy.data.objects] == names
    for contents in contents_of(files):
        assert contents["keys"] == contents["key curves"] == keys


def from_live(skin, other=None):
    """(frames, vertices, 3): the points of a skin with Live off, or of another mesh, minus those of the live skin."""
    skin.sinew.skin.live = True
    live = points_over(skin, FRAMES)
    skin.sinew.skin.live = other is not None
    return points_over(other or skin, FRAMES) - live


def test_a_key_of_ones_own_beside_correctives_is_counted_once(waving, tmp_path):  # noqa: F811
    """Counted twice, the key would move the baked skin, the copy or the file by its whole offset again."""
    skin, rig = waving
    key = add_own_key(skin, rig, 0.03)
    differences, copies = [], []
    for mute in (True, False):
        key.mute = mute
        bake_correctives(skin)
        differences.append(from_live(skin))
        mesh, _rig_copy = bake_bones(rig)
        copies.append(from_live(skin, mesh))
    skin.sinew.skin.live = False
    shown = points_over(skin, FRAMES)
    key.mute = True
    moved_m = np.linalg.norm(points_over(skin, FRAMES) - shown, axis=2).max()
    key.mute = False
    assert moved_m > 0.015
    assert np.linalg.norm(differences[1] - differences[0], axis=2).max() < 0.01 * moved_m
    assert np.linalg.norm(copies[1] - copies[0], axis=2).max() < 0.25 * moved_m
    contents_of(files_of(rig, exported.shown(mesh, FRAMES), tmp_path, "copy"))
