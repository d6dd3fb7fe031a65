# SPDX-License-Identifier: GPL-3.0-or-later
"""What a person does to a file, and what must outlive it: save, reload, undo, duplicate, append, edits, renames."""

import bpy
import numpy as np
import pytest
from conftest import (
    EXTENSOR,
    FLEXOR,
    add_muscle,
    armature_alone,
    bend,
    bind,
    evaluated_points,
    points_of_the_core,
    rest_points,
    save_and_take,
    select,
)


@pytest.fixture(params=[False, True], ids=["bare", "elastic"])
def bent(arm, request):
    skin, rig = arm
    add_muscle(rig, around=FLEXOR)
    skin.sinew.skin.elastic = request.param
    bind(skin)
    bend(rig, 1.2)
    return skin, rig


def swelling(skin):
    return float(np.linalg.norm(evaluated_points(skin) - armature_alone(skin), axis=1).max())


def attribute_of(skin):
    values = np.empty(len(skin.data.vertices) * 3, np.float32)
    skin.data.attributes["sinew_correction"].data.foreach_get("vector", values)
    return values


def test_save_and_reload(bent, tmp_path):
    skin, rig = bent
    before, shown = evaluated_points(skin), bpy.data.objects["Muscle lower"].matrix_world.copy()
    path = str(tmp_path / "arm.blend")
    bpy.ops.wm.save_as_mainfile(filepath=path)
    assert np.array_equal(evaluated_points(skin), before)  # saving changed nothing that is seen
    bpy.ops.wm.open_mainfile(filepath=path)
    skin = bpy.data.objects["Arm"]
    assert np.array_equal(evaluated_points(skin), before)
    bpy.context.view_layer.update()
    now = bpy.data.objects["Muscle lower"].matrix_world
    assert max(abs(a - b) for x, y in zip(now, shown) for a, b in zip(x, y)) < 1e-6


def test_a_file_holds_nothing_derived(bent, tmp_path):
    """Opened where Sinew is not, the mesh is as its Armature modifier leaves it, not as it was at the moment of saving."""
    skin, _rig = bent
    assert np.abs(attribute_of(skin)).max() > 0
    path = str(tmp_path / "arm.blend")
    bpy.ops.wm.save_as_mainfile(filepath=path)
    bpy.ops.wm.read_factory_settings(use_empty=True)
    with bpy.data.libraries.load(path) as (source, target):
        target.objects = list(source.objects)
    assert np.abs(attribute_of(bpy.data.objects["Arm"])).max() == 0
    assert tuple(bpy.data.objects["Muscle lower"].delta_location) == (0, 0, 0)


def test_append(bent, tmp_path):
    before = evaluated_points(bent[0])
    save_and_take(tmp_path / "arm.blend")
    assert np.array_equal(evaluated_points(bpy.data.objects["Arm"]), before)


def test_undo_and_redo(bent):
    skin, rig = bent
    bpy.ops.ed.undo_push(message="bent")
    before = evaluated_points(skin)
    bend(rig, 0.4)
    bpy.ops.ed.undo_push(message="less")
    less = evaluated_points(skin)
    bpy.ops.ed.undo()
    assert np.array_equal(evaluated_points(bpy.data.objects["Arm"]), before)
    bpy.ops.ed.redo()
    assert np.array_equal(evaluated_points(bpy.data.objects["Arm"]), less)


def test_undo_of_bind(arm):
    skin, rig = arm
    add_muscle(rig, around=FLEXOR)
    bpy.ops.ed.undo_push(message="muscle")
    bind(skin)
    bpy.ops.ed.undo_push(message="bind")
    bpy.ops.ed.undo()
    skin = bpy.data.objects["Arm"]
    assert not skin.sinew.skin.bound and [modifier.name for modifier in skin.modifiers] == ["Armature"]
    bend(bpy.data.objects["Arm Rig"], 1.0)
    bpy.ops.ed.redo()


def test_duplicate(bent):
    skin, rig = bent
    select(skin, rig, *[found for found in bpy.data.objects if found.type == "EMPTY"])
    bpy.ops.object.duplicate()
    twin = next(found for found in bpy.context.selected_objects if found.type == "MESH")
    twin_rig = next(found for found in bpy.context.selected_objects if found.type == "ARMATURE")
    bpy.context.view_layer.update()
    assert np.abs(evaluated_points(twin) - evaluated_points(skin)).max() <= 1e-6
    bend(twin_rig, 0.2)
    assert np.abs(evaluated_points(twin) - evaluated_points(skin)).max() > 1e-3
    bend(twin_rig, 1.2)
    assert np.abs(evaluated_points(twin) - evaluated_points(skin)).max() <= 1e-6
    assert swelling(twin) > 5e-4


def test_a_moved_vertex_is_bound_anew(bent):
    skin, rig = bent
    bend(rig, 0.0)
    skin.data.vertices[0].co.z += 0.01
    bpy.context.view_layer.update()
    assert np.abs(evaluated_points(skin) - rest_points(skin)).max() <= 1e-6
    bend(rig, 1.2)
    assert swelling(skin) > 5e-4


def test_a_subdivided_mesh_is_bound_anew(bent):
    skin, rig = bent
    select(skin)
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.ops.mesh.select_all(action="SELECT")
    bpy.ops.mesh.subdivide()
    bpy.ops.object.mode_set(mode="OBJECT")
    bpy.context.view_layer.update()
    assert swelling(skin) > 5e-4
    bend(rig, 0.0)
    assert np.abs(evaluated_points(skin) - rest_points(skin)).max() <= 1e-6


def test_painted_weights_are_bound_anew(bent):
    skin, rig = bent
    index = int(np.argmax(np.linalg.norm(evaluated_points(skin) - rest_points(skin), axis=1)))
    for group in skin.vertex_groups:
        group.remove([index])
    skin.vertex_groups["upper"].add([index], 1.0, "REPLACE")
    bpy.context.view_layer.update()
    assert np.abs(evaluated_points(skin) - points_of_the_core(skin, rig)).max() <= 1e-5


def test_an_edited_muscle_is_bound_anew(bent):
    skin, _rig = bent
    before = evaluated_points(skin)
    muscle = bpy.data.objects["Muscle lower"]
    muscle.scale.x *= 1.3
    muscle.scale.y *= 1.3
    bpy.context.view_layer.update()
    assert np.abs(evaluated_points(skin) - before).max() > 1e-4


def test_a_deleted_muscle_no_longer_acts(bent):
    skin, _rig = bent
    bpy.data.objects.remove(bpy.data.objects["Muscle lower"])
    bpy.context.view_layer.update()
    bpy.context.scene.frame_set(2)
    from bl_ext.user_default.sinew.live import session

    assert swelling(skin) == 0.0
    assert "muscles" in session.reason(skin)


def test_a_renamed_bone_keeps_its_muscle(bent):
    skin, rig = bent
    before = evaluated_points(skin)
    rig.data.bones["lower"].name = "forearm"
    rig.data.bones["upper"].name = "humerus"
    bpy.context.view_layer.update()
    muscle = bpy.data.objects["Muscle lower"]
    assert (muscle.sinew.tissue.origin_bone, muscle.sinew.tissue.insertion_bone) == ("humerus", "forearm")
    bend(rig, 0.3, bone="forearm")
    bend(rig, 1.2, bone="forearm")
    assert np.array_equal(evaluated_points(skin), before)


def test_renamed_objects_stay_bound(bent):
    skin, rig = bent
    before = evaluated_points(skin)
    skin.name, rig.name, bpy.data.objects["Muscle lower"].name = "Skin", "Rigged", "Biceps"
    bend(rig, 0.3)
    bend(rig, 1.2)
    assert np.array_equal(evaluated_points(skin), before)


def test_a_removed_bone_is_named_and_the_rest_goes_on(bent):
    from bl_ext.user_default.sinew.live import session

    skin, rig = bent
    other = add_muscle(rig, name="Other", around=EXTENSOR)
    other.sinew.tissue.insertion_bone = "gone"
    bpy.context.view_layer.update()
    assert swelling(skin) > 5e-4
    problems = session.cached_rig(rig).problems
    assert list(problems) == ["Other"] and "gone" in problems["Other"]


def test_changed_settings_act_at_once(bent):
    skin, _rig = bent
    skin.sinew.skin.elastic = False  # which moves the skin without any swelling
    bpy.context.view_layer.update()
    before = evaluated_points(skin)
    skin.sinew.skin.muscle_influence = 0.0
    bpy.context.view_layer.update()
    assert np.abs(evaluated_points(skin) - armature_alone(skin)).max() == 0.0
    skin.sinew.skin.muscle_influence = 1.0
    bpy.context.view_layer.update()
    assert np.array_equal(evaluated_points(skin), before)
    skin.sinew.skin.live = False
    bpy.context.view_layer.update()
    assert np.abs(evaluated_points(skin) - before).max() > 5e-4


def test_a_disabled_extension_leaves_blenders_own_deformation(bent):
    import addon_utils

    skin, _rig = bent
    alone = armature_alone(skin)
    addon_utils.disable("bl_ext.user_default.sinew")
    bpy.context.view_layer.update()
    assert np.abs(evaluated_points(skin) - alone).max() == 0.0
