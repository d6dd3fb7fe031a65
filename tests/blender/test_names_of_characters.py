# SPDX-License-Identifier: GPL-3.0-or-later
"""Two characters with the same tissue names: saving, loading, removing and mirroring one never touches the other."""

import bpy
import pytest
from bl_ext.user_default.sinew.muscles import portable_names
from bl_ext.user_default.sinew.scene import characters, tissue_empty
from conftest import FLEXOR, add_muscle, make_arm, select
from test_musculature_file import load, save


def names_in(path):
    import json

    return [entry["name"] for entry in json.loads(path.read_text())["tissues"]]


def shapes(rig):
    return {name: repr(tissue_empty.read(empty, rig)) for name, empty in portable_names.of_rig(rig).items()}


@pytest.fixture
def two():
    """(rig, rig): two arms with a Biceps and a Triceps each; the second one's have numbers."""
    rigs = []
    for name in ("A", "B"):
        _skin, rig = make_arm(name)
        add_muscle(rig, name="Biceps", around=FLEXOR)
        add_muscle(rig, name="Triceps", around=-FLEXOR)
        rigs.append(rig)
    assert [empty.name for empty in characters.tissues_of(rigs[1])] == ["Biceps.001", "Triceps.001"]
    return rigs


def duplicate(empty):
    copy = empty.copy()
    for collection in empty.users_collection:
        collection.objects.link(copy)
    bpy.context.view_layer.update()
    return copy


def test_a_duplicated_tissue_of_the_second_character_is_saved_too(two, tmp_path):
    a, b = two
    copy = duplicate(bpy.data.objects["Biceps.001"])
    copy.location.z += 0.01
    before, of_a = shapes(b), shapes(a)
    save(b, tmp_path / "b.json")
    names = names_in(tmp_path / "b.json")
    assert len(names) == 3 and {"Biceps", "Triceps"} < set(names)
    load(b, tmp_path / "b.json")
    assert len(characters.tissues_of(b)) == 3 and set(shapes(b)) == set(before) and shapes(a) == of_a
    again = save(b, tmp_path / "again.json")
    assert again == (tmp_path / "b.json").read_bytes()


def test_a_file_with_numbered_names_loads_on_the_second_character(two, tmp_path):
    a, b = two
    duplicate(bpy.data.objects["Biceps"]).location.z += 0.01
    save(a, tmp_path / "a.json")
    of_a = shapes(a)
    load(b, tmp_path / "a.json")
    load(b, tmp_path / "a.json")
    assert sorted(portable_names.of_rig(b)) == sorted(portable_names.of_rig(a)) == sorted(names_in(tmp_path / "a.json"))
    assert shapes(a) == of_a
    assert save(b, tmp_path / "b.json") == (tmp_path / "a.json").read_bytes()


def test_names_stay_when_the_first_character_is_removed(two, tmp_path):
    a, b = two
    save(b, tmp_path / "b.json")
    select(a)
    bpy.ops.sinew.remove()
    assert sorted(portable_names.of_rig(b)) == ["Biceps", "Triceps"]
    load(b, tmp_path / "b.json")
    assert len(characters.tissues_of(b)) == 2
    add_muscle(b, name="Biceps", around=FLEXOR)
    assert len(characters.tissues_of(b)) == 2


def test_a_preset_again_after_the_other_character_was_removed(real_body):
    _skin, rig = real_body
    select(rig)
    bpy.ops.sinew.add_preset(name="limbs")
    count = len(characters.tissues_of(rig))
    body, other = (found.copy() for found in real_body)
    for found in (body, other):
        bpy.context.scene.collection.objects.link(found)
    other.data = other.data.copy()
    select(other)
    bpy.ops.sinew.add_preset(name="limbs")
    assert len(characters.tissues_of(other)) == count
    select(rig)
    bpy.ops.sinew.remove()
    assert len(characters.tissues_of(other)) == count
    select(other)
    bpy.ops.sinew.add_preset(name="limbs")
    assert len(characters.tissues_of(other)) == count


def test_a_renamed_tissue_is_saved_under_its_new_name(two, tmp_path):
    _a, b = two
    bpy.data.objects["Biceps.001"].name = "Brachialis"
    save(b, tmp_path / "b.json")
    assert names_in(tmp_path / "b.json") == ["Brachialis", "Triceps"]


def test_names_are_those_of_one_tissue_each_whatever_the_numbers(two):
    _a, b = two
    for _ in range(3):
        duplicate(bpy.data.objects["Biceps.001"])
    duplicate(bpy.data.objects["Triceps.001"]).name = "Biceps.002x"
    named = portable_names.of_rig(b)
    assert len(named) == len(characters.tissues_of(b)) == 6
    for name, empty in named.items():
        assert portable_names.find(b, name) == empty and portable_names.portable_name(empty) == name


def test_mirroring_the_second_character_finds_its_own_twins(tmp_path):
    rigs = []
    for name in ("A", "B"):
        data = bpy.data.armatures.new(name)
        rig = bpy.data.objects.new(name, data)
        bpy.context.scene.collection.objects.link(rig)
        select(rig)
        bpy.ops.object.mode_set(mode="EDIT")
        for side, sign in (("L", 1.0), ("R", -1.0)):
            upper, lower = data.edit_bones.new(f"upper.{side}"), data.edit_bones.new(f"lower.{side}")
            upper.head, upper.tail = (0.2 * sign, 0, 1), (0.5 * sign, 0, 1)
            lower.head, lower.tail, lower.parent = (0.5 * sign, 0, 1), (0.8 * sign, 0, 1), upper
        bpy.ops.object.mode_set(mode="OBJECT")
        select(rig)
        bpy.ops.sinew.add_tissue(kind="MUSCLE", name="Biceps.L", origin_bone="upper.L", insertion_bone="lower.L")
        bpy.ops.sinew.add_tissue(kind="SPHERE", name="Ball.L", origin_bone="lower.L")
        muscle, ball = portable_names.find(rig, "Biceps.L"), portable_names.find(rig, "Ball.L")
        muscle.sinew.tissue.wraps.add().sphere = ball
        rigs.append(rig)
        for _ in range(2):
            select(rig)
            bpy.ops.sinew.mirror(direction="LEFT_TO_RIGHT")
        assert sorted(portable_names.of_rig(rig)) == ["Ball.L", "Ball.R", "Biceps.L", "Biceps.R"]
        for side in "LR":
            (wrap,) = portable_names.find(rig, f"Biceps.{side}").sinew.tissue.wraps
            assert wrap.sphere == portable_names.find(rig, f"Ball.{side}")
    save(rigs[0], tmp_path / "a.json")
    assert save(rigs[1], tmp_path / "b.json") == (tmp_path / "a.json").read_bytes()
