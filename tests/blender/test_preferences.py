# SPDX-License-Identifier: GPL-3.0-or-later
"""The preferences: each acts at once, and Sinew can be turned off as a whole without a trace."""

import logging

import bpy
import numpy as np
import pytest
from bl_ext.user_default.sinew.display import anatomy_colours, shaded, translucent_skin, views
from bl_ext.user_default.sinew.files import log
from bl_ext.user_default.sinew.operators import base
from bl_ext.user_default.sinew.scene import characters
from bl_ext.user_default.sinew.settings import preferences
from bl_ext.user_default.sinew.ui import problems
from conftest import add_muscle, armature_alone, bend, evaluated_points, select


@pytest.fixture
def stored():
    """The preferences. They have their defaults again after the test."""
    found = preferences.current()
    yield found
    for name in preferences.SinewPreferences.__annotations__:
        found.property_unset(name)
    preferences.apply()


def test_every_preference_has_a_tooltip(stored):
    own = [found for found in stored.bl_rna.properties if found.identifier in preferences.SinewPreferences.__annotations__]
    assert len(own) > 10
    for found in own:
        assert found.name and len(found.description.split()) >= 3, found.identifier


def test_sinew_is_turned_off_and_on(muscled, stored):
    skin, rig = muscled
    rig.sinew.rig.view = "XRAY"
    bend(rig, 1.2)
    on, alone = evaluated_points(skin), armature_alone(skin)
    assert np.abs(on - alone).max() > 1e-4
    stored.is_enabled = False
    bend(rig, 1.2)
    assert np.abs(evaluated_points(skin) - alone).max() < 1e-6
    assert not translucent_skin.modifier_of(skin).show_viewport and not len(shaded.find(rig).data.vertices)
    select(rig)
    (problem,) = problems.of(bpy.context, rig, characters.character_of(rig))
    bpy.ops.sinew.repair(what=problem.repair, name=problem.name)
    assert stored.is_enabled
    bend(rig, 1.2)
    assert np.abs(evaluated_points(skin) - on).max() < 1e-6
    assert translucent_skin.modifier_of(skin).show_viewport and len(shaded.find(rig).data.vertices)


def test_threads_do_not_change_the_result(muscled, stored):
    skin, rig = muscled
    bend(rig, 1.2)
    before = evaluated_points(skin)
    stored.threads = 1
    bend(rig, 0.0)
    bend(rig, 1.2)
    assert np.array_equal(evaluated_points(skin), before)


def test_colors_change_what_is_shown(muscled, stored):
    _skin, rig = muscled
    rig.sinew.rig.view = "XRAY"
    stored.belly_colour, stored.skin_colour = (0.1, 0.2, 0.3), (0.5, 0.6, 0.7, 0.4)
    belly, translucent = bpy.data.materials["Sinew Belly"], bpy.data.materials["Sinew Translucent Skin"]
    assert tuple(belly.diffuse_color) == pytest.approx((0.1, 0.2, 0.3, 1.0))
    assert tuple(belly.node_tree.nodes["Principled BSDF"].inputs["Base Color"].default_value)[:3] == pytest.approx(
        (0.1, 0.2, 0.3)
    )
    assert tuple(translucent.diffuse_color) == pytest.approx((0.5, 0.6, 0.7, 0.4))
    rig.sinew.rig.view = "SKIN"
    rig.sinew.rig.view = "XRAY"
    assert tuple(bpy.data.materials["Sinew Belly"].diffuse_color)[:3] == pytest.approx((0.1, 0.2, 0.3))
    stored.property_unset("belly_colour")
    preferences.apply()
    assert anatomy_colours.colour_of(anatomy_colours.BELLY)[:3] == pytest.approx(anatomy_colours.DEFAULTS[0])


def test_new_muscles_are_not_shown_if_the_user_does_not_want_it(arm, stored, monkeypatch):
    _skin, rig = arm
    monkeypatch.setattr(base, "is_in_window", lambda: True)
    stored.shows_first = False
    add_muscle(rig)
    assert views.of(rig) == "SKIN"


def test_the_log_has_a_level_and_a_file(stored, tmp_path):
    stored.log_file = str(tmp_path / "sinew.log")
    stored.log_level = "INFO"
    logging.getLogger("sinew").info("An operator did something")
    stored.log_level = "ERROR"
    logging.getLogger("sinew").warning("Not kept")
    stored.log_file = ""
    text = (tmp_path / "sinew.log").read_text()
    assert "An operator did something" in text and "Not kept" not in text
    assert not any("Not kept" in line for line in log.last_lines())


def test_a_log_file_that_cannot_be_written_is_named(stored, tmp_path):
    stored.log_file = str(tmp_path / "missing" / "sinew.log")
    assert "can't be written" in stored.log_problem
    stored.log_file = ""
    assert stored.log_problem == ""


def test_new_skins_get_the_quality_of_the_preferences(arm, stored):
    skin, rig = arm
    add_muscle(rig, name="Biceps")
    stored.new_iterations, stored.new_viewport_detail = 4, "ANCHORS"
    skin.sinew.skin.viewport_detail = "ARMATURE"  # somebody chose this before
    select(skin)
    bpy.ops.sinew.bind()
    settings = skin.sinew.skin
    assert (settings.iterations, settings.viewport_detail, settings.render_detail) == (4, "ARMATURE", "FULL")
    stored.new_iterations = 7
    bpy.ops.sinew.bind()
    assert settings.iterations == 4
