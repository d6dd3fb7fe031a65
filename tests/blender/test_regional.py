# SPDX-License-Identifier: GPL-3.0-or-later
"""Settings of the mesh, of bones and of painted vertices: they reach the live skin and outlive what a person does."""

import bpy
import numpy as np
import pytest
from bl_ext.user_default.sinew import painted_io, regional, session
from conftest import (
    FLEXOR,
    add_muscle,
    armature_alone,
    bend,
    bind,
    evaluated_points,
    link_character,
    make_arm,
    save_character,
    select,
)

INFLUENCE = "sinew_muscle_influence"


@pytest.fixture
def bent(arm):
    """A bound arm that shows the swelling alone, so that what a muscle does is told exactly."""
    skin, rig = arm
    add_muscle(rig, around=FLEXOR)
    skin.sinew.elastic = False
    bind(skin)
    bend(rig, 1.2)
    return skin, rig


def lifts(skin):
    """How far Sinew moves each vertex."""
    return np.linalg.norm(evaluated_points(skin) - armature_alone(skin), axis=1)


def lifted(skin):
    return np.flatnonzero(lifts(skin) > 1e-6)


def add_attribute(skin, values, name=INFLUENCE, kind="FLOAT", domain="POINT"):
    attribute = skin.data.attributes.new(name, kind, domain)
    attribute.data.foreach_set("value", values)
    skin.data.update()
    bpy.context.view_layer.update()
    return attribute


def set_bone(rig, bone, **settings):
    for name, value in settings.items():
        setattr(rig.pose.bones[bone].sinew, name, value)
    bpy.context.view_layer.update()


def evaluated_anew(skin, rig):
    """The points of a bind that is made from the file alone."""
    session.forget()
    rig.update_tag()
    bpy.context.view_layer.update()
    return evaluated_points(skin)


def test_a_painted_attribute_reaches_the_skin(bent):
    skin, rig = bent
    before, moved = lifts(skin), lifted(skin)
    factors = np.ones(len(before), np.float32)
    factors[moved[::2]] = 0.0
    attribute = add_attribute(skin, factors)
    after = lifts(skin)
    assert (after[moved[::2]] == 0.0).all() and np.allclose(after[moved[1::2]], before[moved[1::2]], atol=1e-7)
    attribute.data[int(moved[0])].value = 0.5
    bpy.context.view_layer.update()
    assert lifts(skin)[moved[0]] == pytest.approx(0.5 * before[moved[0]], abs=1e-6)
    assert np.array_equal(evaluated_points(skin), evaluated_anew(skin, rig))
    skin.data.attributes.remove(attribute)
    skin.data.update()
    bpy.context.view_layer.update()
    assert np.array_equal(lifts(skin), before)


def test_a_vertex_outside_the_group_counts_as_weight_0(bent):
    skin, _rig = bent
    before, moved = lifts(skin), lifted(skin)
    select(skin)
    bpy.ops.sinew.paint_region(parameter="muscle_influence")
    assert skin.mode == "WEIGHT_PAINT" and skin.vertex_groups.active.name == INFLUENCE
    assert np.array_equal(lifts(skin), before)  # 1 everywhere changes nothing
    group = skin.vertex_groups[INFLUENCE]
    group.add([int(moved[0])], 0.25, "REPLACE")
    group.add([int(moved[1])], 0.0, "REPLACE")
    group.remove([int(moved[2])])
    skin.data.update()
    bpy.context.view_layer.update()
    after = lifts(skin)
    assert after[moved[0]] == pytest.approx(0.25 * before[moved[0]], abs=1e-6)
    assert after[moved[1]] == after[moved[2]] == 0.0
    assert np.array_equal(after[moved[3:]], before[moved[3:]])
    bpy.ops.object.mode_set(mode="OBJECT")


def test_storages_turn_into_each_other(bent):
    skin, _rig = bent
    index = int(lifted(skin)[0])
    select(skin)
    bpy.ops.sinew.paint_region(parameter="muscle_influence", storage="ATTRIBUTE")
    assert skin.mode == "OBJECT" and skin.data.attributes.active.name == INFLUENCE
    skin.data.attributes[INFLUENCE].data[index].value = 0.5
    skin.data.attributes[INFLUENCE].data[index + 1].value = 3.0
    bpy.ops.sinew.paint_region(parameter="muscle_influence", storage="VERTEX_GROUP")
    assert INFLUENCE not in skin.data.attributes
    assert [round(skin.vertex_groups[INFLUENCE].weight(index + step), 6) for step in (0, 1, 2)] == [0.5, 1.0, 1.0]
    bpy.ops.sinew.paint_region(parameter="muscle_influence", storage="ATTRIBUTE")
    assert INFLUENCE not in skin.vertex_groups and skin.mode == "OBJECT"
    assert painted_io.read(skin)["muscle_influence"][index] == pytest.approx(0.5)
    bpy.ops.sinew.paint_region(parameter="muscle_influence", storage="ATTRIBUTE")
    assert [attribute.name for attribute in skin.data.attributes if attribute.name.startswith(INFLUENCE)] == [INFLUENCE]


def test_an_attribute_goes_before_a_group(bent):
    skin, _rig = bent
    add_attribute(skin, np.zeros(len(skin.data.vertices), np.float32))
    skin.vertex_groups.new(name=INFLUENCE).add(range(len(skin.data.vertices)), 1.0, "REPLACE")
    skin.data.update()
    bpy.context.view_layer.update()
    assert len(lifted(skin)) == 0


@pytest.mark.parametrize(
    ("values", "kind", "words"), [(-1.0, "FLOAT", "is -1 at vertex 0"), (np.nan, "FLOAT", "is nan"), (1, "INT", "not a float")]
)
def test_an_attribute_that_is_no_factor_is_told(bent, values, kind, words):
    skin, rig = bent
    attribute = add_attribute(skin, np.full(len(skin.data.vertices), values), kind=kind)
    assert words in session.reason(skin) and INFLUENCE in session.reason(skin)
    assert len(lifted(skin)) == 0
    with pytest.raises(RuntimeError, match=words):
        bind(skin)
    skin.data.attributes.remove(attribute)
    skin.data.update()
    bend(rig, 1.1)
    assert session.reason(skin) == "" and len(lifted(skin))


def test_painting_is_undone(bent):
    skin, _rig = bent
    select(skin)
    bpy.ops.ed.undo_push(message="bent")
    before = evaluated_points(skin)
    bpy.ops.sinew.paint_region(parameter="muscle_influence", storage="ATTRIBUTE")
    skin.data.attributes[INFLUENCE].data.foreach_set("value", np.zeros(len(skin.data.vertices), np.float32))
    skin.data.update()
    bpy.context.view_layer.update()
    bpy.ops.ed.undo_push(message="painted")
    assert len(lifted(skin)) == 0
    bpy.ops.ed.undo()
    skin = bpy.data.objects["Arm"]
    assert INFLUENCE not in skin.data.attributes and np.array_equal(evaluated_points(skin), before)


def test_a_region_is_painted_from_the_armature_too(bent):
    skin, rig = bent
    select(rig)
    bpy.ops.object.mode_set(mode="POSE")
    bpy.ops.sinew.paint_region(parameter="fat_sliding")
    assert bpy.context.object == skin and skin.mode == "WEIGHT_PAINT"
    assert skin.vertex_groups.active.name == "sinew_fat_sliding"
    bpy.ops.object.mode_set(mode="OBJECT")


def test_what_multiplies_nothing_is_warned_of(bent, capfd):
    skin, _rig = bent
    select(skin)
    bpy.ops.sinew.paint_region(parameter="rest_distance", storage="ATTRIBUTE")
    assert "Rest Distance of Arm is 0" in capfd.readouterr().out
    skin.sinew.rest_distance = 0.01
    bpy.ops.sinew.paint_region(parameter="rest_distance", storage="ATTRIBUTE")
    assert "is 0, and" not in capfd.readouterr().out


def test_a_refused_region_leaves_the_mode(bent):
    skin, _rig = bent
    add_attribute(skin, np.ones(len(skin.data.vertices), np.int32), kind="INT")
    select(skin)
    bpy.ops.object.mode_set(mode="SCULPT")
    with pytest.raises(RuntimeError, match="not a float"):
        bpy.ops.sinew.paint_region(parameter="muscle_influence")
    assert skin.mode == "SCULPT" and INFLUENCE not in skin.vertex_groups
    skin.data.attributes.remove(skin.data.attributes[INFLUENCE])
    bpy.ops.sinew.paint_region(parameter="muscle_influence")
    assert skin.mode == "WEIGHT_PAINT"
    bpy.ops.object.mode_set(mode="OBJECT")


def test_painted_groups_are_no_bone_weights(bent):
    skin, rig = bent
    before = evaluated_points(skin)
    select(skin)
    for parameter in regional.PARAMETERS:
        bpy.ops.sinew.paint_region(parameter=parameter.name)
    bpy.ops.object.mode_set(mode="OBJECT")
    assert np.array_equal(evaluated_points(skin), before)
    assert np.array_equal(evaluated_anew(skin, rig), before)


def test_a_bones_influence_scales_what_it_carries(bent):
    skin, rig = bent
    before = lifts(skin)
    set_bone(rig, "upper", muscle_influence=0.5)
    set_bone(rig, "lower", muscle_influence=0.5)
    assert np.allclose(lifts(skin), 0.5 * before, atol=1e-6)
    set_bone(rig, "upper", muscle_influence=0.0)
    after = lifts(skin)
    upper_alone = np.array([[element.group for element in vertex.groups] == [0] for vertex in skin.data.vertices])
    assert before[upper_alone].max() > 1e-3 and after[upper_alone].max() == 0.0 < after.max()
    assert np.array_equal(evaluated_points(skin), evaluated_anew(skin, rig))
    rig.pose.bones["upper"].property_unset("sinew")
    set_bone(rig, "lower", muscle_influence=1.0)
    assert np.array_equal(lifts(skin), before)


@pytest.mark.parametrize("name", regional.OF_BONE)
def test_every_setting_of_a_bone_makes_the_bind_anew(bent, name):
    skin, rig = bent
    skin.sinew.elastic = True
    bend(rig, 1.2)
    kept = session.kept_skin(skin)
    bend(rig, 1.1)
    assert session.kept_skin(skin) is kept
    set_bone(rig, "lower", **{name: 0.5})
    assert session.kept_skin(skin) is not kept
    assert session.kept_skin(skin).bone_settings[name].tolist() == [1.0, 0.5, 1.0]  # upper, lower, the armature itself


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("energy", "SPRINGS"), ("anchor_stiffness", 2.0), ("edge_stiffness", 0.5), ("rest_distance", 0.01),
        ("fat_sliding", 0.5), ("collides", True), ("contacts", False), ("iterations", 3), ("elastic", False),
    ],
)  # fmt: skip
def test_every_setting_of_the_mesh_makes_the_bind_anew(bent, name, value):
    skin, rig = bent
    skin.sinew.elastic = True
    bend(rig, 1.1)
    kept = session.kept_skin(skin)
    setattr(skin.sinew, name, value)
    bpy.context.view_layer.update()
    assert session.kept_skin(skin) is not kept and session.reason(skin) == ""
    assert np.isfinite(evaluated_points(skin)).all()


def test_the_joints_of_a_bendy_bone_have_its_settings(bent):
    skin, rig = bent
    rig.data.bones["lower"].bbone_segments = 3
    set_bone(rig, "lower", muscle_influence=0.0)
    factors = session.kept_rig(rig).bone_settings["muscle_influence"]
    assert factors.tolist() == [1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0]


def test_settings_survive_saving_undo_and_renaming(bent, tmp_path):
    skin, rig = bent
    plain = evaluated_points(skin)
    bpy.ops.ed.undo_push(message="bent")
    set_bone(rig, "upper", muscle_influence=0.5)
    bpy.ops.ed.undo_push(message="set")
    set_points = evaluated_points(skin)
    assert np.abs(set_points - plain).max() > 1e-4
    bpy.ops.ed.undo()
    assert np.array_equal(evaluated_points(bpy.data.objects["Arm"]), plain)
    bpy.ops.ed.redo()
    assert np.array_equal(evaluated_points(bpy.data.objects["Arm"]), set_points)
    bpy.data.objects["Arm Rig"].data.bones["upper"].name = "humerus"
    bpy.context.view_layer.update()
    assert np.array_equal(evaluated_points(bpy.data.objects["Arm"]), set_points)
    skin = bpy.data.objects["Arm"]
    add_attribute(skin, np.linspace(0.0, 1.0, len(skin.data.vertices), dtype=np.float32))
    painted_points = evaluated_points(skin)
    assert not np.array_equal(painted_points, set_points)
    path = str(tmp_path / "arm.blend")
    bpy.ops.wm.save_as_mainfile(filepath=path)
    bpy.ops.wm.open_mainfile(filepath=path)
    assert np.array_equal(evaluated_points(bpy.data.objects["Arm"]), painted_points)


def overridden(tmp_path):
    """(mesh, rig): all that is there, linked from a file of its own and overridden."""
    library = str(tmp_path / "library.blend")
    save_character(library)
    return link_character(library)


def of_the_saved_shot(tmp_path):
    """The override of each type, after the shot was saved and opened again."""
    shot = str(tmp_path / "shot.blend")
    bpy.ops.wm.save_as_mainfile(filepath=shot)
    bpy.ops.wm.open_mainfile(filepath=shot)
    return {found.type: found for found in bpy.data.objects if found.override_library}


def test_an_overridden_characters_bones_have_settings_of_their_own(bent, tmp_path):
    _skin, rig = bent
    set_bone(rig, "lower", muscle_influence=0.5)  # "upper" has nothing of its own in the library
    skin, rig = overridden(tmp_path)
    before = evaluated_points(skin)
    assert rig.pose.bones["lower"].sinew.muscle_influence == 0.5
    set_bone(rig, "upper", muscle_influence=0.0, crease=0.25)
    after = evaluated_points(skin)
    assert np.abs(after - before).max() > 1e-4
    shot = of_the_saved_shot(tmp_path)
    own = shot["ARMATURE"].pose.bones["upper"].sinew
    assert (own.muscle_influence, own.crease) == (0.0, 0.25)
    assert np.abs(evaluated_points(shot["MESH"]) - after).max() <= 1e-6


@pytest.mark.parametrize(("name", "value"), [("gain", 0.0), ("rest_distance", 0.25), ("elastic", True), ("energy", "SPRINGS")])
def test_an_overridden_skin_has_settings_of_its_own(bent, tmp_path, name, value):
    skin, _rig = overridden(tmp_path)
    setattr(skin.sinew, name, value)
    assert getattr(of_the_saved_shot(tmp_path)["MESH"].sinew, name) == value


def test_an_overridden_muscle_has_a_tension_of_its_own(bent, tmp_path):
    overridden(tmp_path)
    next(found for found in bpy.data.objects if found.type == "EMPTY" and found.override_library).sinew.tension = 0.75
    assert of_the_saved_shot(tmp_path)["EMPTY"].sinew.tension == 0.75


def test_settings_are_copied_to_the_segment_the_selection_and_the_other_side():
    from bl_ext.user_default.sinew import rig_io

    rig = make_rig(
        {
            "arm01.L": ((0, 0, 0), (1, 0, 0), None), "arm02.L": ((1, 0, 0), (2, 0, 0), "arm01.L"),
            "hand.L": ((2, 0, 0), (3, 0, 0), "arm02.L"), "arm01.R": ((0, 0, 0), (-1, 0, 0), None),
            "arm02.R": ((-1, 0, 0), (-2, 0, 0), "arm01.R"), "hand.R": ((-2, 0, 0), (-3, 0, 0), "arm02.R"),
        }
    )  # fmt: skip

    def settings(bone):
        own = rig.pose.bones[bone].sinew
        return own.anchor_stiffness, own.crease

    assert rig_io.bones_of_segment(rig, "arm02.L") == ["arm01.L", "arm02.L"]
    with pytest.raises(RuntimeError, match="Make the bone active"):
        bpy.ops.sinew.copy_bone_settings()
    rig.data.bones.active = rig.data.bones["arm01.L"]
    set_bone(rig, "arm01.L", anchor_stiffness=2.0, crease=0.5)
    bpy.ops.sinew.copy_bone_settings(to="SEGMENT")
    assert settings("arm02.L") == (2.0, 0.5) and settings("hand.L") == settings("arm01.R") == (1.0, 1.0)
    bpy.ops.sinew.copy_bone_settings(to="MIRROR")
    assert settings("arm01.R") == settings("arm02.R") == (2.0, 0.5) and settings("hand.R") == (1.0, 1.0)
    deselect_all(rig)
    with pytest.raises(RuntimeError, match="Select other bones"):
        bpy.ops.sinew.copy_bone_settings(to="SELECTED")
    bone = rig.pose.bones["hand.R"]
    (bone if hasattr(bone, "select") else bone.bone).select = True
    bpy.ops.sinew.copy_bone_settings(to="SELECTED")
    assert settings("hand.R") == (2.0, 0.5) and settings("hand.L") == (1.0, 1.0)
    rig.data.bones.active = rig.data.bones["hand.L"]
    with pytest.raises(RuntimeError, match="segment of its own"):
        bpy.ops.sinew.copy_bone_settings(to="SEGMENT")


def deselect_all(rig):
    for bone in rig.pose.bones:
        (bone if hasattr(bone, "select") else bone.bone).select = False


def make_rig(bones):
    armature = bpy.data.armatures.new("Rig")
    rig = bpy.data.objects.new("Rig", armature)
    bpy.context.scene.collection.objects.link(rig)
    select(rig)
    bpy.ops.object.mode_set(mode="EDIT")
    for name, (head, tail, parent) in bones.items():
        bone = armature.edit_bones.new(name)
        bone.head, bone.tail = head, tail
        bone.parent = armature.edit_bones.get(parent) if parent else None
    bpy.ops.object.mode_set(mode="OBJECT")
    armature.bones.active = None
    return rig


def test_unbind_keeps_what_was_painted_and_remove_takes_it(bent):
    skin, rig = bent
    select(skin)
    bpy.ops.sinew.paint_region(parameter="muscle_influence")
    bpy.ops.sinew.paint_region(parameter="edge_stiffness", storage="ATTRIBUTE")
    set_bone(rig, "lower", anchor_stiffness=2.0)
    other, _other_rig = make_arm("Other")
    other.vertex_groups.new(name=INFLUENCE)
    select(skin)
    bpy.ops.sinew.unbind()
    assert INFLUENCE in skin.vertex_groups and "sinew_edge_stiffness" in skin.data.attributes
    assert rig.pose.bones["lower"].sinew.anchor_stiffness == 2.0
    bpy.ops.sinew.remove()
    assert skin.vertex_groups.keys() == ["upper", "lower"]
    assert not [attribute.name for attribute in skin.data.attributes if attribute.name.startswith("sinew")]
    assert not any(bone.is_property_set("sinew") for bone in rig.pose.bones)
    assert INFLUENCE in other.vertex_groups


def test_a_linked_mesh_is_not_painted(bent, tmp_path):
    skin, _rig = bent
    path = str(tmp_path / "arm.blend")
    bpy.ops.wm.save_as_mainfile(filepath=path)
    bpy.ops.wm.read_factory_settings(use_empty=True)
    with bpy.data.libraries.load(path, link=True) as (_source, target):
        target.objects = ["Arm"]
    bpy.context.scene.collection.objects.link(target.objects[0])
    select(target.objects[0])
    with pytest.raises(RuntimeError, match="linked from another file"):
        bpy.ops.sinew.paint_region()
