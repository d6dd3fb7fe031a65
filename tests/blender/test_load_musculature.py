# SPDX-License-Identifier: GPL-3.0-or-later
"""Loading a musculature file on the character that it was saved from."""

import json

import bpy
import pytest
from bl_ext.user_default.sinew.scene import characters
from conftest import problems_of

pytestmark = pytest.mark.one_blender


def test_save_load_save_on_the_character_itself(human, tmp_path):
    """Loading writes to existing Empties, whose angles may be near 90 degrees."""
    files = [tmp_path / f"{number}.json" for number in range(3)]
    for path in files:
        bpy.ops.sinew.save_musculature(filepath=str(path))
        bpy.ops.sinew.load_musculature(filepath=str(path))
    assert files[0].read_bytes() == files[1].read_bytes() == files[2].read_bytes()


def test_loading_keeps_the_space_of_an_empty(human, tmp_path):
    """Keys and drivers of its location are in this space."""
    femur = bpy.data.objects["Femur.L"]
    before = femur.matrix_parent_inverse.copy()
    path = str(tmp_path / "human.json")
    bpy.ops.sinew.save_musculature(filepath=path)
    bpy.ops.sinew.load_musculature(filepath=path)
    assert femur.matrix_parent_inverse == before


@pytest.mark.parametrize("replace_all", [True, False])
@pytest.mark.parametrize("is_bare", [True, False])
def test_a_file_without_a_wrapping_sphere(human, tmp_path, capfd, replace_all, is_bare):
    path = tmp_path / "human.json"
    bpy.ops.sinew.save_musculature(filepath=str(path))
    content = json.loads(path.read_text(encoding="utf-8"))
    content["tissues"] = [tissue for tissue in content["tissues"] if tissue["name"] != "Shoulder joint.L"]
    path.write_text(json.dumps(content), encoding="utf-8")
    if is_bare:
        bpy.ops.sinew.remove()
    bpy.ops.sinew.load_musculature(filepath=str(path), replace_all=replace_all)
    is_lost = replace_all or is_bare
    wraps = bpy.data.objects["Deltoid, acromial part.L"].sinew.tissue.wraps
    assert [wrap.sphere.name for wrap in wraps if wrap.sphere] == ([] if is_lost else ["Shoulder joint.L"])
    assert ("wraps around 'Shoulder joint.L'" in capfd.readouterr().out) == is_lost
    assert len(characters.tissues_of(human)) == (558 if is_lost else 559)
    assert not problems_of(human)
