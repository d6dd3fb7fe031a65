# SPDX-License-Identifier: GPL-3.0-or-later
"""Choosing a tissue by a click or in the list: it is selected and orange, and the only one with an Empty."""

import bpy
import numpy as np
import pytest
from bl_ext.user_default.sinew.display import anatomy_colours, ellipsoid_nodes, shaded
from bl_ext.user_default.sinew.operators import choose_tissue
from bl_ext.user_default.sinew.scene import characters, selection
from conftest import add_muscle, bend, select
from mathutils import Vector


@pytest.fixture
def character(arm):
    """An arm in the view X-ray with two muscles on opposite sides, without Empties."""
    skin, rig = arm
    add_muscle(rig, name="Front", around=0.0, offset=0.15)
    add_muscle(rig, name="Back", around=np.pi, offset=0.15)
    bpy.ops.sinew.add_tissue(kind="BONE", origin_bone="lower", name="Bone")
    rig.sinew.rig.show_empties = False
    rig.sinew.rig.view = "XRAY"
    rig.location = (1.0, 2.0, 3.0)
    bpy.context.view_layer.update()
    return skin, rig


def posed_centre(rig, name):
    """The centre of a straight tissue in the current pose, in world space."""
    from bl_ext.user_default.sinew.live import ellipsoids, session

    state = session.cached_rig(rig)
    found = ellipsoids.of(state)
    row = state.solved.index([empty.name for empty in characters.tissues_of(rig)].index(name))
    return rig.matrix_world @ Vector(found.matrices[list(found.owners).index(row), 3, :3])


def name_at(start, along):
    found = choose_tissue.tissue_at(bpy.context, start, along)
    return found.name if found else None


@pytest.mark.parametrize("angle", [0.0, 0.9])
def test_a_ray_meets_the_first_muscle_through_the_skin(character, angle):
    _skin, rig = character
    bend(rig, angle)
    for name, other in (("Front", "Back"), ("Back", "Front")):
        centre = posed_centre(rig, name)
        away = (centre - posed_centre(rig, other)).normalized()
        assert name_at(centre + 2.0 * away, -3.0 * away) == name
    assert name_at(Vector((1.0, 2.0, 9.0)), Vector((0.0, 1.0, 0.0))) is None


def test_what_is_in_front_hides_muscles(character):
    _skin, rig = character
    centre = posed_centre(rig, "Front")
    away = (centre - posed_centre(rig, "Back")).normalized()
    bpy.ops.mesh.primitive_cube_add(size=0.2, location=centre + away)
    assert name_at(centre + 2.0 * away, -away) is None
    bpy.context.object.location = centre - away
    bpy.context.view_layer.update()
    assert name_at(centre + 2.0 * away, -away) == "Front"


def test_only_layers_that_are_on_can_be_chosen(character):
    _skin, rig = character
    centre = posed_centre(rig, "Front")
    away = (centre - posed_centre(rig, "Back")).normalized()
    rig.sinew.rig.show_muscles = False
    bpy.context.view_layer.update()
    assert name_at(centre + 2.0 * away, -away) in (None, "Bone")
    rig.sinew.rig.view = "SKIN"
    assert name_at(centre + 2.0 * away, -away) is None


def test_the_chosen_muscle_alone_has_an_empty_and_is_orange(character):
    _skin, rig = character
    front, back = bpy.data.objects["Front"], bpy.data.objects["Back"]
    selection.select(front)
    assert front.visible_get() and front.select_get() and not back.visible_get()
    selection.select(back)
    assert back.visible_get() and bpy.context.selected_objects == [back] and not front.visible_get()
    bpy.context.view_layer.update()
    mesh = shaded.find(rig).data
    shapes = np.empty(len(mesh.vertices), np.int32)
    mesh.attributes[ellipsoid_nodes.SHAPE].data.foreach_get("value", shapes)
    assert (shapes == ellipsoid_nodes.FIRST_OF_ANATOMY + anatomy_colours.CHOSEN).sum() == 1


def test_the_chosen_muscle_shows_the_pose(character):
    _skin, rig = character
    front = bpy.data.objects["Front"]
    bend(rig, 0.9)
    selection.select(front)
    bpy.context.view_layer.update()
    rig.update_tag()
    bpy.context.view_layer.update()
    assert (front.matrix_world.translation - posed_centre(rig, "Front")).length < 1e-4


def test_the_via_points_of_the_chosen_muscle_are_shown(human):
    human.sinew.rig.show_empties = False
    via = characters.vias_of(human)[0]
    assert not via.visible_get()
    selection.select(via.sinew.tissue.muscle)
    assert via.visible_get()
    others = [other for other in characters.vias_of(human) if other.sinew.tissue.muscle != via.sinew.tissue.muscle]
    assert others and not any(other.visible_get() for other in others)


def test_deleting_the_chosen_muscle_leaves_no_trace(character):
    _skin, rig = character
    selection.select(bpy.data.objects["Front"])
    bpy.ops.object.delete()
    bpy.context.view_layer.update()
    assert "Front" not in bpy.data.objects and len(characters.tissues_of(rig)) == 2


def test_a_click_needs_object_mode_and_a_view_with_muscles(character):
    _skin, rig = character
    assert not bpy.ops.sinew.choose_tissue.poll()  # no viewport in a script
    select(rig)
    bpy.ops.object.mode_set(mode="POSE")
    assert not bpy.ops.sinew.choose_tissue.poll()
