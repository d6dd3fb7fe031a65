# SPDX-License-Identifier: GPL-3.0-or-later
"""The muscle display: layers by kind, muscles shaded by stretch and attachment lines, and that it leaves no trace."""

import math

import bpy
import numpy as np
import pytest
from bl_ext.user_default.sinew.display import shaded, stretch_colours
from bl_ext.user_default.sinew.live import attachments, ellipsoids, session
from bl_ext.user_default.sinew.scene import characters
from conftest import add_muscle, bend, bind, evaluated_points, select
from mathutils import Vector


@pytest.fixture
def character(arm):
    skin, rig = arm
    add_muscle(rig, name="Biceps", around=math.pi / 2)
    for kind in ("BONE", "STUFFING", "SPHERE"):
        bpy.ops.sinew.add_tissue(kind=kind, origin_bone="lower", name=kind.title())
    rig.sinew.rig.colours = "STRETCH"
    bpy.context.view_layer.update()
    return skin, rig


def seen_ellipsoids(rig):
    """(matrix, material name) of each shaded ellipsoid that Blender evaluates."""
    bpy.context.view_layer.update()
    found = shaded.find(rig)
    seen = []
    for instance in bpy.context.evaluated_depsgraph_get().object_instances:
        if instance.is_instance and instance.parent and instance.parent.original == found:
            mesh = instance.object.data
            seen.append((np.array(instance.matrix_world), mesh.materials[mesh.polygons[0].material_index]))
    return seen


def posed(rig):
    """The matrices of the tissues, as the Empties show them."""
    state = session.cached_rig(rig)
    out = np.empty_like(state.posed)
    state.musculature.pose(state.pose, state.tension, out)
    return out.transpose(0, 2, 1)


def posed_ellipsoids(rig):
    found = ellipsoids.of(session.cached_rig(rig))
    return found.matrices.transpose(0, 2, 1), found.stretch


def count(rig, *kinds):
    """The number of ellipsoids of the tissues of some kinds, or of all."""
    tissues = characters.tissues_of(rig)
    state = session.cached_rig(rig)
    owners = [tissues[state.solved[owner]].sinew.tissue.kind for owner in ellipsoids.of(state).owners]
    return sum(not kinds or kind in kinds for kind in owners)


def same_ellipsoid(seen, wanted):
    return np.abs(seen @ seen.T - wanted @ wanted.T).max() < 1e-5 and np.abs(seen[:3, 3] - wanted[:3, 3]).max() < 1e-5


@pytest.mark.parametrize("angle", [0.0, 1.2])
def test_shaded_muscles_are_the_posed_ellipsoids(character, angle):
    _skin, rig = character
    bend(rig, angle)
    rig.sinew.rig.show_shaded = True
    assert rig.sinew.rig.show_shaded
    rig.location = (0.1, 0.2, 0.3)
    seen = seen_ellipsoids(rig)
    wanted, stretch = posed_ellipsoids(rig)
    assert len(seen) == len(wanted) >= 4
    to_world = np.array(rig.matrix_world)
    for (matrix, material), ellipsoid, step in zip(seen, wanted, stretch_colours.steps_of(stretch)):
        assert same_ellipsoid(matrix, to_world @ ellipsoid)
        assert tuple(material.diffuse_color) == pytest.approx(stretch_colours.colour_of(step), abs=1e-6)
    bend(rig, angle + 0.5)
    wanted, _stretch = posed_ellipsoids(rig)
    for (matrix, _material), ellipsoid in zip(seen_ellipsoids(rig), wanted):
        assert same_ellipsoid(matrix, to_world @ ellipsoid)


def test_colours_range_from_blue_over_white_to_red():
    steps = stretch_colours.steps_of(np.array([0.1, 0.6, 0.95, 1.0, 1.05, 1.4, 9.0]))
    assert list(steps) == sorted(steps) and steps[0] == 0 and steps[3] == stretch_colours.STEPS // 2
    blue, white, red = map(stretch_colours.colour_of, (0, stretch_colours.STEPS // 2, stretch_colours.STEPS - 1))
    assert blue[2] > 2 * blue[0] and min(white[:3]) > 0.8 and red[0] > 2 * red[2]


def test_shaded_muscles_cannot_be_selected_or_rendered(character):
    skin, rig = character
    rig.sinew.rig.show_shaded = True
    found = shaded.find(rig)
    assert found.hide_select and found.hide_render
    assert characters.skins_of(rig) == [skin]
    bind(skin)
    select(rig)
    bpy.ops.sinew.bind()
    assert not found.sinew.skin.bound
    bpy.ops.sinew.add_tissue(kind="STUFFING", origin_bone="upper", name="More")
    assert len(seen_ellipsoids(rig)) == count(rig) >= 5


def names_in_file():
    kinds = (bpy.data.objects, bpy.data.meshes, bpy.data.materials, bpy.data.node_groups, bpy.data.collections)
    return [sorted(found.name for found in kind) for kind in kinds]


@pytest.mark.parametrize("by", ["switch", "remove"])
def test_muscle_display_leaves_no_trace(arm, by):
    _skin, rig = arm
    before = names_in_file()
    add_muscle(rig)
    if by == "switch":
        before = names_in_file()
    rig.sinew.rig.show_shaded = True
    bpy.context.view_layer.update()
    if by == "switch":
        rig.sinew.rig.show_shaded = False
    else:
        select(rig)
        bpy.ops.sinew.remove()
    assert names_in_file() == before


def test_a_file_holds_nothing_derived(character, tmp_path):
    _skin, rig = character
    bend(rig, 1.0)
    rig.sinew.rig.show_shaded = True
    assert len(seen_ellipsoids(rig)) == count(rig)
    path = str(tmp_path / "a.blend")
    bpy.ops.wm.save_as_mainfile(filepath=path)
    assert len(seen_ellipsoids(rig)) == count(rig)
    bpy.ops.wm.read_factory_settings(use_empty=True)
    with bpy.data.libraries.load(path) as (source, target):
        target.meshes = list(source.meshes)
    assert [len(mesh.vertices) for mesh in target.meshes if "Shaded" in mesh.name] == [0]
    bpy.ops.wm.open_mainfile(filepath=path)
    rig = bpy.data.objects["Arm Rig"]
    assert len(seen_ellipsoids(rig)) == count(rig) >= 4


def test_undo_of_shaded_muscles(character):
    _skin, rig = character
    bpy.ops.ed.undo_push(message="before")
    rig.sinew.rig.show_shaded = True
    bpy.context.view_layer.update()
    bpy.ops.ed.undo_push(message="shaded")
    bpy.ops.ed.undo()
    rig = bpy.data.objects["Arm Rig"]
    assert not rig.sinew.rig.show_shaded and "Arm Rig Shaded Muscles" not in bpy.data.objects
    bpy.ops.ed.redo()
    rig = bpy.data.objects["Arm Rig"]
    assert len(seen_ellipsoids(rig)) == count(rig) >= 4


def test_kinds_are_shown_and_hidden(character):
    _skin, rig = character
    rig.sinew.rig.show_shaded = True
    rig.sinew.rig.show_bones = False
    assert bpy.data.objects["Bone"].hide_get() and not bpy.data.objects["Biceps"].hide_get()
    assert len(seen_ellipsoids(rig)) == 3
    rig.sinew.rig.show_empties = False
    assert all(empty.hide_get() for empty in characters.tissues_of(rig))
    assert len(seen_ellipsoids(rig)) == 3
    select(rig)
    bpy.ops.sinew.add_tissue(kind="STUFFING", origin_bone="upper", name="More")
    assert bpy.data.objects["More"].hide_get()
    rig.sinew.rig.show_bones = rig.sinew.rig.show_empties = True
    assert not any(empty.hide_get() for empty in characters.tissues_of(rig))


def test_hidden_muscles_show_the_pose_when_shown_again(character):
    _skin, rig = character
    rig.sinew.rig.show_muscles = False
    bend(rig, 1.2)
    rig.sinew.rig.show_muscles = True
    bpy.context.view_layer.update()
    empty = bpy.data.objects["Biceps"]
    wanted = posed(rig)[session.cached_rig(rig).solved.index(characters.tissues_of(rig).index(empty))]
    assert same_ellipsoid(np.array(empty.matrix_world), np.array(rig.matrix_world) @ wanted)


def test_disabled_muscles_show_the_pose_when_enabled_again(character):
    _skin, rig = character
    empty = bpy.data.objects["Biceps"]
    empty.hide_viewport = True
    bend(rig, 1.2)
    empty.hide_viewport = False
    bpy.context.view_layer.update()
    rig.update_tag()
    bpy.context.view_layer.update()
    wanted = posed(rig)[session.cached_rig(rig).solved.index(characters.tissues_of(rig).index(empty))]
    assert same_ellipsoid(np.array(empty.matrix_world), wanted)


def is_evaluated(empty):
    bpy.context.view_layer.update()
    return empty.evaluated_get(bpy.context.evaluated_depsgraph_get()).is_evaluated


def test_blender_does_not_evaluate_a_layer_that_is_off(character):
    _skin, rig = character
    biceps, bone = bpy.data.objects["Biceps"], bpy.data.objects["Bone"]
    bone.hide_viewport = True  # a choice of the user, which layers do not change
    for switch in ("show_empties", "show_muscles"):
        setattr(rig.sinew.rig, switch, False)
        assert biceps.hide_viewport and not is_evaluated(biceps), switch
        setattr(rig.sinew.rig, switch, True)
        assert not biceps.hide_viewport and is_evaluated(biceps), switch
        assert bone.hide_viewport


def test_a_layer_that_is_off_can_be_shown_after_loading(character, tmp_path):
    _skin, rig = character
    rig.sinew.rig.show_empties = False
    path = str(tmp_path / "a.blend")
    bpy.ops.wm.save_as_mainfile(filepath=path)
    bpy.ops.wm.open_mainfile(filepath=path)
    assert not is_evaluated(bpy.data.objects["Biceps"])
    bpy.data.objects["Arm Rig"].sinew.rig.show_empties = True
    assert is_evaluated(bpy.data.objects["Biceps"])


@pytest.mark.parametrize("when", ["before", "after"])
def test_a_driver_acts_while_its_layer_is_off(character, when):
    skin, rig = character
    bind(skin)
    bend(rig, 0.5)
    biceps = bpy.data.objects["Biceps"]

    def drive():
        biceps.driver_add("sinew.tissue.tension").driver.expression = "0.7"

    if when == "before":
        drive()
    rig.sinew.rig.show_empties = False
    bpy.context.view_layer.update()
    if when == "after":
        drive()
    bend(rig, 0.6)
    bend(rig, 0.7)
    tensions = session.cached_rig(rig).tension
    assert biceps.hide_get() and tensions.max() == pytest.approx(0.7)


def widen(biceps):
    biceps.sinew.tissue.semi_axes = [1.5 * value for value in biceps.sinew.tissue.semi_axes]


def shift(biceps):
    biceps.sinew.tissue.offset += 0.02


def lengthen_tendon(biceps):
    biceps.sinew.tissue.origin_tendon += 0.02


def tense(biceps):
    biceps.sinew.tissue.tension = 1.0


def parent_to_another_bone(biceps):
    biceps.sinew.tissue.origin_bone = "lower"


def pull_nothing(biceps):
    biceps.sinew.tissue.insertion_bone = ""


SETTINGS = (widen, shift, lengthen_tendon, tense, parent_to_another_bone, pull_nothing)


def scale(biceps):
    biceps.scale.x *= 1.5


def enlarge(biceps):
    biceps.empty_display_size *= 1.5


def shift_from_parent(biceps):
    inverse = biceps.matrix_parent_inverse.copy()
    inverse[0][3] += 0.02
    biceps.matrix_parent_inverse = inverse


@pytest.mark.parametrize("edit", [*SETTINGS, scale, enlarge, shift_from_parent])
def test_edits_while_a_layer_is_off_have_an_effect(character, edit):
    skin, rig = character
    bind(skin)
    rig.sinew.rig.show_empties = False
    bend(rig, 1.2)
    before = evaluated_points(skin)
    edit(bpy.data.objects["Biceps"])
    bpy.context.view_layer.update()
    if edit not in SETTINGS:
        bend(rig, 1.2)  # Blender does not report what a script moves there: it has an effect from the next pose or frame
    seen = evaluated_points(skin)
    assert np.abs(seen - before).max() > 2e-6
    session.forget()
    bend(rig, 1.2)
    assert np.array_equal(evaluated_points(skin), seen)


@pytest.mark.parametrize("angle", [0.0, 1.2])
def test_attachment_lines_follow_the_bones(character, angle):
    from bl_ext.user_default.sinew.scene import tissue_empty

    _skin, rig = character
    bend(rig, angle)
    shape = tissue_empty.read(bpy.data.objects["Biceps"], rig)
    origin, belly_start, belly_end, insertion = attachments.lines_of(rig, session.cached_rig(rig))
    bones = rig.pose.bones
    for end, bone, point in ((origin, "upper", shape.origin), (insertion, "lower", shape.insertion)):
        wanted = bones[bone].matrix @ bones[bone].bone.matrix_local.inverted() @ point
        assert np.abs(end - np.array(wanted)).max() < 1e-5
    assert np.linalg.norm(belly_start - origin) == pytest.approx(shape.origin_tendon, abs=1e-5)
    assert np.linalg.norm(insertion - belly_end) == pytest.approx(shape.insertion_tendon, abs=1e-5)


def test_layers_are_off_by_default(arm):
    _skin, rig = arm
    assert not rig.sinew.rig.show_shaded and not rig.sinew.rig.show_attachments


def test_switching_shaded_muscles_does_not_bind_again(character):
    """Adding or removing an object changes only the indices of the Empties in the file."""
    skin, rig = character
    bind(skin)
    bend(rig, 0.5)
    rig.sinew.rig.show_shaded = True
    bpy.context.view_layer.update()
    kept = session.cached_skin(skin)
    for shown in (False, True, False):
        rig.sinew.rig.show_shaded = shown
        bpy.context.view_layer.update()
        bpy.context.scene.frame_set(bpy.context.scene.frame_current + 1)
        assert session.cached_skin(skin) is kept


@pytest.mark.parametrize("mode", ["XYZ", "XZY", "YXZ", "YZX", "ZXY", "ZYX", "QUATERNION"])
def test_an_empty_shows_the_pose_in_every_rotation_mode(character, mode):
    _skin, rig = character
    empty = bpy.data.objects["Biceps"]
    empty.rotation_mode = mode
    empty.rotation_euler = (0.5, -0.7, 1.2)
    empty.rotation_quaternion = (0.8, 0.2, -0.5, 0.3)
    rig.pose.bones["upper"].rotation_quaternion = (0.7, 0.5, 0.3, -0.4)
    bend(rig, 1.2)
    own = (empty.location.copy(), empty.rotation_euler.copy(), empty.rotation_quaternion.copy(), empty.scale.copy())
    wanted = posed(rig)[session.cached_rig(rig).solved.index(characters.tissues_of(rig).index(empty))]
    assert same_ellipsoid(np.array(empty.matrix_world), np.array(rig.matrix_world) @ wanted)
    bend(rig, 0.3)
    assert own == (empty.location, empty.rotation_euler, empty.rotation_quaternion, empty.scale)


def test_other_objects_keep_their_delta_transforms(character):
    _skin, rig = character
    other = bpy.data.objects.new("Other", None)
    bpy.context.scene.collection.objects.link(other)
    other.delta_location, other.delta_rotation_euler, other.delta_scale = (1, 2, 3), (0.1, 0.2, 0.3), (4, 5, 6)
    other.delta_rotation_quaternion = (0.5, 0.5, 0.5, 0.5)
    before = (*other.delta_location, *other.delta_rotation_euler, *other.delta_rotation_quaternion, *other.delta_scale)
    bend(rig, 1.2)
    assert bpy.data.objects["Biceps"].delta_scale != Vector((1, 1, 1))
    after = (*other.delta_location, *other.delta_rotation_euler, *other.delta_rotation_quaternion, *other.delta_scale)
    assert before == after


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
