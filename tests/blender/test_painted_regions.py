# SPDX-License-Identifier: GPL-3.0-or-later
"""Painted factors: they have an effect on the live skin in either storage, and can be removed."""

import bpy
import numpy as np
import pytest
from bl_ext.user_default.sinew.live import session
from bl_ext.user_default.sinew.scene import painted_data, skin_regions
from conftest import (
    add_attribute,
    bend,
    bind,
    evaluated_after_binding_again,
    evaluated_points,
    lifted,
    lifts,
    make_arm,
    select,
    set_bone,
)

INFLUENCE = "sinew_muscle_influence"


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
    assert np.array_equal(evaluated_points(skin), evaluated_after_binding_again(skin, rig))
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
    assert np.array_equal(lifts(skin), before)  # 1 everywhere has no effect
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


def test_attribute_and_vertex_group_convert_to_each_other(bent):
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
    assert painted_data.read(skin)["muscle_influence"][index] == pytest.approx(0.5)
    bpy.ops.sinew.paint_region(parameter="muscle_influence", storage="ATTRIBUTE")
    assert [attribute.name for attribute in skin.data.attributes if attribute.name.startswith(INFLUENCE)] == [INFLUENCE]


def test_an_attribute_takes_precedence_over_a_group(bent):
    skin, _rig = bent
    add_attribute(skin, np.zeros(len(skin.data.vertices), np.float32))
    skin.vertex_groups.new(name=INFLUENCE).add(range(len(skin.data.vertices)), 1.0, "REPLACE")
    skin.data.update()
    bpy.context.view_layer.update()
    assert len(lifted(skin)) == 0


@pytest.mark.parametrize(
    ("values", "kind", "words"),
    [(-1.0, "FLOAT", "is -1 at vertex 0"), (np.nan, "FLOAT", "is nan"), (1, "INT", "not a float")],
)
def test_an_attribute_of_the_wrong_kind_is_reported(bent, values, kind, words):
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


def test_a_painted_factor_without_effect_is_warned_of(bent, capfd):
    skin, _rig = bent
    select(skin)
    bpy.ops.sinew.paint_region(parameter="slack", storage="ATTRIBUTE")
    assert "Slack of Arm is 0" in capfd.readouterr().out
    skin.sinew.skin.slack = 0.01
    bpy.ops.sinew.paint_region(parameter="slack", storage="ATTRIBUTE")
    assert "is 0, so" not in capfd.readouterr().out


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


def test_painted_groups_are_not_bone_weights(bent):
    skin, rig = bent
    before = evaluated_points(skin)
    select(skin)
    for parameter in skin_regions.PARAMETERS:
        bpy.ops.sinew.paint_region(parameter=parameter.name)
    bpy.ops.object.mode_set(mode="OBJECT")
    assert np.array_equal(evaluated_points(skin), before)
    assert np.array_equal(evaluated_after_binding_again(skin, rig), before)


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


def test_unbind_keeps_painted_values_and_remove_deletes_them(bent):
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


def test_the_former_name_of_a_setting_warns_and_paints_the_current_one(bent):
    skin, _rig = bent
    select(skin)
    with pytest.warns(DeprecationWarning, match="'rest_distance' is now 'slack'"):
        bpy.ops.sinew.paint_region(parameter="rest_distance")
    assert "sinew_slack" in skin.vertex_groups
