# SPDX-License-Identifier: GPL-3.0-or-later
"""Handles of muscles and the tool that draws a muscle on the body."""

import bpy
import numpy as np
import pytest
from bl_ext.user_default.sinew.errors import SinewError
from bl_ext.user_default.sinew.muscles import reshape
from bl_ext.user_default.sinew.muscles.placing.place import drawn
from bl_ext.user_default.sinew.operators import draw_muscle
from bl_ext.user_default.sinew.scene import characters, surface_hit, tissue_empty
from bl_ext.user_default.sinew.ui import muscle_gizmos
from conftest import FLEXOR, add_muscle, bend, bind, select
from mathutils import Vector

HANDLES = (reshape.ORIGIN, reshape.INSERTION, reshape.WIDTH_X, reshape.WIDTH_Y)


@pytest.fixture
def muscle(arm):
    _skin, rig = arm
    empty = add_muscle(rig, name="Biceps", around=FLEXOR)
    rig.location = (1.0, 2.0, 0.5)
    bpy.context.view_layer.update()
    select(empty)
    return empty


def shape_of(muscle):
    return tissue_empty.read(muscle, muscle.parent)


def same(left, right, within=1e-5):
    return (Vector(left) - Vector(right)).length < within


@pytest.mark.parametrize("end", [0, 1])
def test_moving_an_end_keeps_the_other_end_the_widths_and_the_proportions(muscle, end):
    shape = shape_of(muscle)
    ends = [shape.origin, shape.insertion]
    ends[end] = ends[end] + Vector((0.02, -0.03, 0.04))
    moved = reshape.with_ends(shape, *ends)
    assert same(moved.origin, ends[0]) and same(moved.insertion, ends[1])
    assert moved.semi_axes.x == shape.semi_axes.x and moved.semi_axes.y == shape.semi_axes.y
    factor = (ends[1] - ends[0]).length / (shape.insertion - shape.origin).length
    assert moved.semi_axes.z == pytest.approx(factor * shape.semi_axes.z)
    assert moved.origin_tendon == pytest.approx(factor * shape.origin_tendon)


def test_a_muscle_without_length_is_refused(muscle):
    shape = shape_of(muscle)
    with pytest.raises(SinewError, match="no length"):
        reshape.with_ends(shape, shape.origin, shape.origin)


def test_the_belly_moves_between_the_ends(muscle):
    shape = shape_of(muscle)
    for fraction, tendons in ((0.0, (0.0, 1.0)), (1.0, (1.0, 0.0)), (0.5, (0.5, 0.5))):
        moved = reshape.with_belly_at(shape, fraction)
        free = shape.origin_tendon + shape.insertion_tendon
        assert (moved.origin_tendon, moved.insertion_tendon) == pytest.approx([free * part for part in tendons])
        assert same(moved.origin, shape.origin) and same(moved.insertion, shape.insertion)


@pytest.mark.parametrize("angle", [0.0, 1.1])
@pytest.mark.parametrize("handle", HANDLES)
def test_a_handle_goes_where_it_is_dragged_in_any_pose(muscle, handle, angle):
    rig = muscle.parent
    bend(rig, angle)
    select(muscle)
    before = muscle_gizmos.points_of(muscle)
    across = {
        reshape.WIDTH_X: before[handle] - muscle_centre(muscle),
        reshape.WIDTH_Y: before[handle] - muscle_centre(muscle),
    }
    target = before[handle] + across.get(handle, Vector((0.01, 0.02, 0.03)))
    bpy.ops.sinew.drag_handle(handle=handle, position=target)
    bpy.context.view_layer.update()
    after = muscle_gizmos.points_of(muscle)
    assert same(after[handle], target, 2e-5)
    others = {reshape.ORIGIN: reshape.INSERTION, reshape.INSERTION: reshape.ORIGIN}
    if handle in others:
        assert same(after[others[handle]], before[others[handle]], 2e-5)


def muscle_centre(muscle):
    rig, shape = muscle.parent, shape_of(muscle)
    return rig.matrix_world @ (reshape.to_pose(rig, shape.origin_bone) @ shape.centre)


def test_via_points_have_handles(muscle):
    bpy.ops.sinew.add_via_point()
    select(muscle)
    handles = muscle_gizmos.points_of(muscle)
    assert "VIA 0" in handles
    target = handles["VIA 0"] + Vector((0.0, 0.01, 0.02))
    bpy.ops.sinew.drag_handle(handle="VIA 0", position=target)
    assert same(muscle_gizmos.points_of(muscle)["VIA 0"], target, 2e-5)
    (via,) = tissue_empty.vias_of(muscle)
    select(via)
    assert muscle_gizmos.muscle_of_context(bpy.context) == muscle


def test_an_unknown_handle_is_named(muscle):
    with pytest.raises(RuntimeError, match="no handle 'NOSE'"):
        bpy.ops.sinew.drag_handle(handle="NOSE")


def test_a_drag_is_one_step_back(muscle):
    before = tuple(muscle.location)
    bpy.ops.ed.undo_push(message="before")
    bpy.ops.sinew.drag_handle(handle="ORIGIN", position=(1.0, 2.0, 0.6))
    assert tuple(muscle.location) != before
    bpy.ops.ed.undo_push(message="drag")
    bpy.ops.ed.undo()
    assert tuple(bpy.data.objects["Biceps"].location) == pytest.approx(before)


def test_a_drag_is_mirrored_with_x_mirror(rigify):
    bpy.ops.object.armature_human_metarig_add()
    rig = bpy.context.object
    bpy.ops.sinew.add_preset(name="limbs")
    rig.data.pose_position = "REST"
    rig.sinew.rig.mirror_x = True
    bpy.context.view_layer.update()
    left, right = (
        next(e for e in characters.tissues_of(rig) if e.name.startswith("Biceps") and e.name.endswith(s))
        for s in (".L", ".R")
    )
    select(left)
    handles = muscle_gizmos.points_of(left)
    bpy.ops.sinew.drag_handle(handle="WIDTH_X", position=2.0 * handles["WIDTH_X"] - muscle_centre(left))
    bpy.context.view_layer.update()
    assert right.scale.x == pytest.approx(left.scale.x, rel=1e-3)


def test_sliding_keeps_the_distance_from_the_bone(muscle):
    rig = muscle.parent
    for point in (Vector((0.1, 0.3, 0.2)), Vector((0.9, 0.0, 0.01)), Vector((0.2, 0.0, 0.0))):
        slid = reshape.on_bone(rig, "upper", point, 0.04)
        assert reshape.distance_to_bone(rig, "upper", slid) == pytest.approx(0.04, abs=1e-6)


@pytest.mark.parametrize("angle", [0.0, 0.9])
def test_a_click_on_the_skin_finds_the_bone(arm, angle):
    skin, rig = arm
    add_muscle(rig)
    bind(skin)
    bend(rig, angle)
    for bone, at in (("upper", 0.4), ("lower", 0.7)):
        pose = rig.pose.bones[bone]
        middle = pose.head.lerp(pose.tail, at)
        hit = surface_hit.first_hit(bpy.context, rig, middle + Vector((0, 0, 1)), Vector((0, 0, -2)))
        assert hit.bone == bone and hit.point.z == pytest.approx(0.05, abs=0.01)
    assert surface_hit.first_hit(bpy.context, rig, Vector((5, 5, 5)), Vector((0, 0, 1))) is None


@pytest.mark.parametrize("angle", [0.0, 0.9])
def test_a_drawn_muscle_is_under_the_clicks_in_any_pose(arm, angle):
    _skin, rig = arm
    bend(rig, angle)
    select(rig)
    points = [
        rig.pose.bones[bone].head.lerp(rig.pose.bones[bone].tail, 0.6) + Vector((0, 0, 0.05)) for bone in ("upper", "lower")
    ]
    bpy.ops.sinew.draw_muscle(origin=points[0], insertion=points[1], width=0.012, belly=0.3)
    empty = bpy.context.object
    shape = shape_of(empty)
    assert (shape.origin_bone, shape.insertion_bone) == ("upper", "lower")
    assert shape.semi_axes.x == pytest.approx(0.012) and shape.origin_tendon < shape.insertion_tendon
    handles = muscle_gizmos.points_of(empty)
    for handle, point in ((reshape.ORIGIN, points[0]), (reshape.INSERTION, points[1])):
        assert (handles[handle] - point).length == pytest.approx(0.05 * drawn.DEPTH, abs=2e-3)


def test_drawing_twice_adds_two_muscles(arm):
    _skin, rig = arm
    select(rig)
    for _ in range(2):
        bpy.ops.sinew.draw_muscle(origin=(0.15, 0, 0.05), insertion=(0.45, 0, 0.05))
        select(rig)
    assert [empty.name for empty in characters.tissues_of(rig)] == ["Muscle lower", "Muscle lower 2"]


def test_both_ends_on_one_bone_are_refused(arm):
    _skin, rig = arm
    select(rig)
    with pytest.raises(RuntimeError, match="Both ends are on 'upper'"):
        bpy.ops.sinew.draw_muscle(origin=(0.1, 0, 0.05), insertion=(0.2, 0, 0.05))
    assert draw_muscle.nearest_bone(rig, Vector((0.5, 0, 0))) == "lower"


def test_handles_follow_a_muscle_with_a_problem_without_an_error(muscle):
    muscle.sinew.tissue.insertion_bone = "gone"
    assert muscle_gizmos.points_of(muscle) == {}
    assert np.isfinite(muscle.location).all()
