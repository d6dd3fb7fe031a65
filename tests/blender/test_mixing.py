# SPDX-License-Identifier: GPL-3.0-or-later
"""Mute, Solo, Influence, groups, copy and paste, and the heat map of what a tissue moves."""

import bpy
import numpy as np
import pytest
from bl_ext.user_default.sinew.live import session
from bl_ext.user_default.sinew.muscles import groups
from bl_ext.user_default.sinew.operators import paste_tissue
from bl_ext.user_default.sinew.scene import characters, selection
from bl_ext.user_default.sinew.ui import moved_overlay
from conftest import EXTENSOR, FLEXOR, add_muscle, bend, bind, evaluated_points, lifts, make_arm, select


@pytest.fixture
def two_muscles(arm):
    """(mesh, rig): a bound, bent arm with a flexor and an extensor, without elastic skin."""
    skin, rig = arm
    add_muscle(rig, name="Flexor.L", around=FLEXOR)
    add_muscle(rig, name="Extensor.L", around=EXTENSOR)
    skin.sinew.skin.elastic = False
    bind(skin)
    bend(rig, 1.2)
    return skin, rig


def set_tissue(name, **values):
    for key, value in values.items():
        setattr(bpy.data.objects[name].sinew.tissue, key, value)
    bpy.context.view_layer.update()


def solved_names(rig):
    tissues = characters.tissues_of(rig)
    return [tissues[index].name for index in session.cached_rig(rig).solved]


def without(rig, skin, name):
    """The points after the muscle is deleted."""
    bpy.data.objects.remove(bpy.data.objects[name])
    characters.forget()
    bend(rig, 1.2)
    return evaluated_points(skin)


def test_a_muted_muscle_has_the_effect_of_a_deleted_one(two_muscles):
    skin, rig = two_muscles
    before = evaluated_points(skin)
    set_tissue("Flexor.L", muted=True)
    muted = evaluated_points(skin)
    assert solved_names(rig) == ["Extensor.L"] and np.abs(muted - before).max() > 1e-4
    set_tissue("Flexor.L", muted=False)
    assert np.abs(evaluated_points(skin) - before).max() < 1e-6
    assert np.abs(without(rig, skin, "Flexor.L") - muted).max() < 1e-6


def test_solo_mutes_all_other_muscles_and_wins_over_mute(two_muscles):
    _skin, rig = two_muscles
    bpy.ops.sinew.add_tissue(kind="SPHERE", origin_bone="lower", name="Elbow")
    set_tissue("Flexor.L", solo=True, muted=True)
    assert solved_names(rig) == ["Elbow", "Flexor.L"]
    set_tissue("Flexor.L", solo=False)
    assert solved_names(rig) == ["Elbow", "Extensor.L"]


def test_influence_scales_the_swelling(two_muscles):
    skin, _rig = two_muscles
    sizes = []
    for influence in (0.0, 0.5, 1.0):
        set_tissue("Flexor.L", influence=influence)
        set_tissue("Extensor.L", influence=0.0)
        sizes.append(float(lifts(skin).max()))
    assert sizes[0] < 1e-5 < sizes[1] < sizes[2]


def test_influence_scales_tension(two_muscles):
    skin, rig = two_muscles
    set_tissue("Flexor.L", tension=0.8, influence=0.5)
    state = session.cached_rig(rig)
    row = solved_names(rig).index("Flexor.L")
    assert state.tension[row] == pytest.approx(0.4)


def test_a_new_session_computes_the_same(two_muscles):
    skin, rig = two_muscles
    set_tissue("Flexor.L", influence=0.3)
    set_tissue("Extensor.L", muted=True)
    before = evaluated_points(skin)
    session.forget()
    rig.update_tag()
    bpy.context.view_layer.update()
    assert np.array_equal(evaluated_points(skin), before)


def test_groups_by_region(human):
    select(human)
    bpy.ops.sinew.group_tissues(by="REGION")
    names = groups.names(human)
    assert names == [group.name for group in human.sinew.rig.groups]
    assert set(names) == {"Arm.L", "Arm.R", "Head", "Leg.L", "Leg.R", "Trunk"}
    of = {tissue.name: tissue.sinew.tissue.group for tissue in characters.tissues_of(human)}
    assert of["Biceps brachii, long head.L"] == "Arm.L" and of["Soleus.R"] == "Leg.R"
    assert all(of.values())
    left, right = groups.members(human, "Arm.L"), groups.members(human, "Arm.R")
    assert len(left) == len(right) > 20


def test_a_rig_that_is_not_recognised_can_be_grouped_by_hand(two_muscles):
    _skin, rig = two_muscles
    select(rig)
    with pytest.raises(RuntimeError, match="Arm Rig"):
        bpy.ops.sinew.group_tissues(by="REGION")
    select(rig)
    with pytest.raises(RuntimeError, match="No tissue is selected"):
        bpy.ops.sinew.group_tissues(by="SELECTED")
    select(bpy.data.objects["Flexor.L"])
    bpy.ops.sinew.group_tissues(by="SELECTED", name="Front")
    assert groups.names(rig) == ["Front"] and [found.name for found in groups.members(rig, "Front")] == ["Flexor.L"]


@pytest.fixture
def grouped(two_muscles):
    skin, rig = two_muscles
    select(bpy.data.objects["Flexor.L"], bpy.data.objects["Extensor.L"])
    bpy.ops.sinew.group_tissues(by="SELECTED", name="All")
    return skin, rig


def test_a_group_changes_all_its_muscles(grouped):
    skin, rig = grouped
    before = evaluated_points(skin)
    group = rig.sinew.rig.groups["All"]
    group.tension = 0.7
    bpy.context.view_layer.update()
    values = [bpy.data.objects[name].sinew.tissue.tension for name in ("Flexor.L", "Extensor.L")]
    assert values == pytest.approx([0.7, 0.7]) and np.abs(evaluated_points(skin) - before).max() > 1e-5
    group.muted = True
    bpy.context.view_layer.update()
    assert session.cached_rig(rig).musculature is None
    group.muted, group.influence = False, 0.25
    assert bpy.data.objects["Flexor.L"].sinew.tissue.influence == 0.25


def test_the_tension_of_a_group_is_keyed(grouped):
    _skin, rig = grouped
    for frame, tension in ((1, 0.0), (11, 1.0)):
        bpy.context.scene.frame_set(frame)
        rig.sinew.rig.groups["All"].tension = tension
        bpy.ops.sinew.key_group(group="All")
    bpy.context.scene.frame_set(6)
    assert session.cached_rig(rig).tension == pytest.approx([0.5, 0.5], abs=0.01)


def test_a_group_is_selected(grouped):
    _skin, rig = grouped
    rig.sinew.rig.show_empties = False
    select(rig)
    bpy.ops.sinew.select_group(group="All")
    assert {found.name for found in bpy.context.selected_objects} == {"Flexor.L", "Extensor.L"}
    with pytest.raises(RuntimeError, match="no tissue in the group 'None'"):
        bpy.ops.sinew.select_group(group="None")


def test_a_tissue_is_pasted_to_a_larger_character(two_muscles):
    _skin, _rig = two_muscles
    source = bpy.data.objects["Flexor.L"]
    source.sinew.tissue.semi_axes = (0.03, 0.02, 0.1)
    source.sinew.tissue.origin_tendon, source.sinew.tissue.volume_keeping = 0.02, 0.6
    values = paste_tissue.read(paste_tissue.json.dumps(paste_tissue._values_of(source)))
    _other_skin, other = make_arm("Other")
    target = add_muscle(other, name="Target")
    target.sinew.tissue.semi_axes = (0.01, 0.01, 0.2)
    paste_tissue._write(target.sinew.tissue, values)
    assert list(target.sinew.tissue.semi_axes) == pytest.approx([0.06, 0.04, 0.2])
    assert target.sinew.tissue.origin_tendon == pytest.approx(0.04)
    assert target.sinew.tissue.volume_keeping == pytest.approx(0.6)


@pytest.mark.parametrize("text", ["", "hello", "{}", '{"format": "sinew tissue 1"}', "[1, 2]", "null"])
def test_a_foreign_clipboard_is_refused(text):
    with pytest.raises(Exception, match="clipboard has no tissue"):
        paste_tissue.read(text)


def test_the_heat_map_shows_what_the_chosen_tissue_moves(two_muscles):
    skin, rig = two_muscles
    assert moved_overlay.weights_of(skin, rig) is None  # nothing is chosen
    selection.select(bpy.data.objects["Flexor.L"])
    flexor = moved_overlay.weights_of(skin, rig)
    selection.select(bpy.data.objects["Extensor.L"])
    extensor = moved_overlay.weights_of(skin, rig)
    assert flexor.max() > 0.5 and extensor.max() > 0.5 and flexor.min() == 0.0
    # the two are on opposite sides of the arm
    assert np.corrcoef(flexor, extensor)[0, 1] < 0.0
    points, triangles = moved_overlay.triangles_of(skin, bpy.context.evaluated_depsgraph_get())
    assert len(points) == len(flexor) and triangles.max() < len(points)
    colours = moved_overlay.colours_of(np.array([0.0, 0.3, 1.0], np.float32))
    assert colours[0, 3] == 0.0 and colours[2, 0] == 1.0 and colours[2, 3] > 0.5


def test_a_muted_tissue_moves_nothing(two_muscles):
    skin, rig = two_muscles
    selection.select(bpy.data.objects["Flexor.L"])
    set_tissue("Flexor.L", muted=True)
    assert moved_overlay.weights_of(skin, rig) is None
