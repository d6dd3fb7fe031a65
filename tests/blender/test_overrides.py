# SPDX-License-Identifier: GPL-3.0-or-later
"""Characters that are linked from another file and overridden, as productions use them."""

import bpy
import numpy as np
import pytest
from conftest import FLEXOR, add_muscle, bend, bind, evaluated_points, link_character, make_arm, rest_points, save_character


@pytest.fixture
def library(tmp_path):
    """(path, points): a file with a bound character in the collection "Character", and how its mesh bends by 1.2."""
    skin, rig = make_arm()
    add_muscle(rig, around=FLEXOR)
    bind(skin)
    bend(rig, 1.2)
    points = evaluated_points(skin)
    bend(rig, 0.0)
    path = str(tmp_path / "library.blend")
    save_character(path)
    return path, points


def test_an_override_is_live(library, tmp_path):
    path, points = library
    skin, rig = link_character(path)
    assert skin.data.library is not None
    bend(rig, 1.2)
    assert np.abs(evaluated_points(skin) - points).max() <= 1e-6
    bend(rig, 0.0)
    assert np.abs(evaluated_points(skin) - rest_points(skin)).max() <= 1e-6
    bend(rig, 1.2)
    shot = str(tmp_path / "shot.blend")
    bpy.ops.wm.save_as_mainfile(filepath=shot)
    bpy.ops.wm.open_mainfile(filepath=shot)
    skin = next(found for found in bpy.data.objects if found.type == "MESH" and found.override_library)
    assert np.abs(evaluated_points(skin) - points).max() <= 1e-6


def test_two_overrides_of_one_character_are_told_apart(library):
    from bl_ext.user_default.sinew import session

    path, _points = library
    skin, rig = link_character(path)
    twin, twin_rig = link_character(path)
    assert twin != skin and twin.data == skin.data
    bend(rig, 1.2)
    bend(twin_rig, 0.4)
    assert "single user" in session.reason(skin) and "single user" in session.reason(twin)
