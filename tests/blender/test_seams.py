# SPDX-License-Identifier: GPL-3.0-or-later
"""Where presets, curved muscles, mirror, files and layers meet each other."""

import json

import bpy
import pytest
from bl_ext.user_default.sinew.live import session
from bl_ext.user_default.sinew.muscles import edit, mirror
from bl_ext.user_default.sinew.scene import characters, tissue_empty
from conftest import add_muscle, select
from mathutils import Matrix, Quaternion, Vector

ACROSS = Matrix.Diagonal((-1.0, 1.0, 1.0))
LED, TWIN = "Sartorius.L", "Sartorius.R"  # of the preset's muscles one that passes a via point


@pytest.fixture
def human(rigify):
    """Rigify's human metarig with the human preset: muscles with via points and wraps."""
    bpy.ops.object.armature_human_metarig_add()
    rig = bpy.context.object
    bpy.ops.sinew.add_preset(name="human")
    bpy.context.view_layer.update()
    return rig


def deleted(name):
    """Deletes an object as a person does, with X."""
    select(bpy.data.objects[name])
    bpy.ops.object.delete()
    bpy.context.view_layer.update()


def names_of(rig):
    return [empty.name for empty in characters.tissues_of(rig)]


def problems_of(rig):
    bpy.context.view_layer.update()
    return session.cached_rig(rig).problems


def side_of(empty):
    return mirror.side_of(empty.name, empty.sinew.tissue.origin_bone, empty.sinew.tissue.insertion_bone)


def test_the_time_of_the_one_click_is_reported(human, capfd):
    bpy.ops.sinew.add_preset(name="human")
    assert "160 muscles and 50 other tissues added to metarig" in capfd.readouterr().out


def test_via_points_are_hidden_with_their_muscles(human):
    vias = characters.vias_of(human)
    assert vias and not any(via.hide_get() for via in vias)
    for switch in ("show_muscles", "show_empties"):
        setattr(human.sinew.rig, switch, False)
        assert all(via.hide_get() for via in vias), switch
        setattr(human.sinew.rig, switch, True)
        assert not any(via.hide_get() for via in vias), switch
    human.sinew.rig.show_muscles = False
    bpy.ops.sinew.add_preset(name="human")
    assert all(via.hide_get() for via in characters.vias_of(human))


def test_x_mirror_follows_a_dragged_via_point(human):
    human.sinew.rig.mirror_x = True
    via = tissue_empty.vias_of(bpy.data.objects[LED])[0]
    via.location.z += 0.01
    bpy.context.view_layer.update()
    (_, own), (_, twin) = (tissue_empty.read(bpy.data.objects[name], human).via_points[0] for name in (LED, TWIN))
    assert (ACROSS @ own - twin).length < 1e-5


def test_mirror_brings_a_deleted_muscle_back(human):
    deleted(TWIN)
    assert TWIN not in names_of(human)
    select(bpy.data.objects[LED])
    bpy.ops.sinew.mirror()
    assert TWIN in names_of(human)
    assert len(tissue_empty.vias_of(bpy.data.objects[TWIN])) == 1
    assert len(characters.vias_of(human)) == 2


def test_a_preset_brings_a_deleted_muscle_back_under_its_name(human):
    before = names_of(human)
    deleted(TWIN)
    select(human)
    bpy.ops.sinew.add_preset(name="human")
    assert names_of(human) == before


def test_remove_takes_deleted_muscles_and_their_via_points(human):
    deleted(TWIN)
    select(human)
    bpy.ops.sinew.remove()
    assert list(bpy.data.objects) == [human]


@pytest.mark.parametrize("operator", ["add_via_point", "remove_via_points", "wrap"])
def test_a_via_point_of_a_deleted_muscle_says_so(human, operator):
    via = tissue_empty.vias_of(bpy.data.objects[LED])[0]
    deleted(LED)
    select(via)
    with pytest.raises(RuntimeError, match="its muscle Sartorius.L was deleted"):
        getattr(bpy.ops.sinew, operator)()


def test_a_whole_side_is_mirrored_with_the_spheres_that_its_muscles_go_round(human):
    before = names_of(human)
    edit.remove([empty for empty in characters.tissues_of(human) if side_of(empty) == "R"])
    bpy.context.view_layer.update()
    select(human)
    bpy.ops.sinew.mirror(direction="LEFT_TO_RIGHT")
    assert names_of(human) == before
    wraps = {
        tuple(mirror.flipped(wrap.sphere.name) for wrap in empty.sinew.tissue.wraps)
        for empty in characters.tissues_of(human)
    }
    assert wraps == {tuple(wrap.sphere.name for wrap in empty.sinew.tissue.wraps) for empty in characters.tissues_of(human)}
    assert not problems_of(human)


def test_a_muscle_whose_twin_has_no_sphere_to_go_round_is_named_and_the_rest_mirrored(human, capfd):
    edit.remove([bpy.data.objects["Shoulder joint.R"]])
    bpy.context.view_layer.update()
    select(bpy.data.objects["Biceps brachii, long head.L"], bpy.data.objects["Deltoid, acromial part.L"])
    bpy.ops.sinew.mirror()
    printed = capfd.readouterr().out
    assert "wraps around sphere 'Shoulder joint.R', which metarig does not have" in printed
    assert "1 tissues mirrored" in printed


def test_save_load_save_on_the_character_itself(human, tmp_path):
    """Loading writes on Empties that are there, whose angles may be near 90 degrees."""
    files = [tmp_path / f"{number}.json" for number in range(3)]
    for path in files:
        bpy.ops.sinew.save_musculature(filepath=str(path))
        bpy.ops.sinew.load_musculature(filepath=str(path))
    assert files[0].read_bytes() == files[1].read_bytes() == files[2].read_bytes()


def test_loading_keeps_the_space_of_an_empty(human, tmp_path):
    """Keys and drivers of its location are in that space."""
    femur = bpy.data.objects["Femur.L"]
    before = femur.matrix_parent_inverse.copy()
    path = str(tmp_path / "human.json")
    bpy.ops.sinew.save_musculature(filepath=path)
    bpy.ops.sinew.load_musculature(filepath=path)
    assert femur.matrix_parent_inverse == before


def test_another_origin_bone_leaves_a_tissue_where_it_is(arm):
    _, rig = arm
    muscle = add_muscle(rig)
    before = tissue_empty.read(muscle, rig)
    muscle.sinew.tissue.origin_bone = "lower"
    after = tissue_empty.read(muscle, rig)
    assert after.origin_bone == "lower"
    assert (after.origin - before.origin).length < 1e-6
    assert (after.insertion - before.insertion).length < 1e-6


@pytest.mark.parametrize("order", ["XYZ", "XZY", "YXZ", "YZX", "ZXY", "ZYX"])
def test_a_rotation_near_90_degrees_is_written_exactly(arm, order):
    _, rig = arm
    muscle = add_muscle(rig)
    muscle.rotation_mode = order
    for angle in (1.5, 1.57, 1.5707, -1.5706):
        middle = Quaternion(tuple(float(axis == order[1]) for axis in "XYZ"), angle)
        wanted = Quaternion(tuple(float(axis == order[0]) for axis in "XYZ"), 0.9) @ middle
        muscle.rotation_euler = tissue_empty._euler_of(wanted, order)
        amiss = wanted.rotation_difference(muscle.rotation_euler.to_quaternion())
        assert Vector((amiss.x, amiss.y, amiss.z)).length < 1e-6


@pytest.mark.parametrize("replace_all", [True, False])
@pytest.mark.parametrize("is_bare", [True, False])
def test_a_file_without_a_sphere_that_its_muscles_go_round(human, tmp_path, capfd, replace_all, is_bare):
    path = tmp_path / "human.json"
    bpy.ops.sinew.save_musculature(filepath=str(path))
    told = json.loads(path.read_text(encoding="utf-8"))
    told["tissues"] = [tissue for tissue in told["tissues"] if tissue["name"] != "Shoulder joint.L"]
    path.write_text(json.dumps(told), encoding="utf-8")
    if is_bare:
        bpy.ops.sinew.remove()
    bpy.ops.sinew.load_musculature(filepath=str(path), replace_all=replace_all)
    is_lost = replace_all or is_bare
    wraps = bpy.data.objects["Deltoid, acromial part.L"].sinew.tissue.wraps
    assert [wrap.sphere.name for wrap in wraps if wrap.sphere] == ([] if is_lost else ["Shoulder joint.L"])
    assert ("wraps around 'Shoulder joint.L'" in capfd.readouterr().out) == is_lost
    assert len(characters.tissues_of(human)) == (209 if is_lost else 210)
    assert not problems_of(human)


def test_fitting_keeps_left_and_right_mirrored(real_body):
    _, rig = real_body
    select(rig)
    bpy.ops.sinew.add_preset(name="human", fit_skin=False)
    select(rig)
    bpy.ops.sinew.fit()
    shapes = {shape.name: shape for shape in (tissue_empty.read(empty, rig) for empty in characters.tissues_of(rig))}
    for name in filter(lambda name: name.endswith(".L"), shapes):
        left, right = shapes[name], shapes[mirror.flipped(name)]
        assert (ACROSS @ left.centre - right.centre).length < 1e-5, name
        assert (left.semi_axes - right.semi_axes).length < 1e-5, name


def test_a_horse_is_no_cat(rigify, capfd):
    bpy.ops.object.armature_horse_metarig_add()
    horse = bpy.context.object
    bpy.ops.sinew.add_preset(name="cat")
    assert "(Rigify horse)" in capfd.readouterr().out
    muscles = [empty for empty in characters.tissues_of(horse) if empty.sinew.tissue.kind == "MUSCLE"]
    assert len(muscles) == 128
    assert not problems_of(horse)


@pytest.mark.parametrize("name", dir(bpy.ops.sinew))
@pytest.mark.parametrize("where", ["nothing", "a light", "a mesh in Edit Mode", "an armature in Edit Mode"])
def test_where_an_operator_cannot_work_its_poll_says_why(name, where):
    if where == "a light":
        bpy.ops.object.light_add()
    elif where == "a mesh in Edit Mode":
        bpy.ops.mesh.primitive_cube_add()
        bpy.ops.object.mode_set(mode="EDIT")
    elif where == "an armature in Edit Mode":
        bpy.ops.object.armature_add()
        bpy.ops.object.mode_set(mode="EDIT")
    operator = getattr(bpy.ops.sinew, name)
    assert not operator.poll()
    with pytest.raises(RuntimeError, match=r"poll\(\) (Select|Make|Leave|Light|Point)"):
        operator()
