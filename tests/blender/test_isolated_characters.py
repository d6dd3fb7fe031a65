# SPDX-License-Identifier: GPL-3.0-or-later
"""A failure in one character does not touch the others: it is logged once, and the panel shows the reason."""

import logging

import bpy
import numpy as np
import pytest
from bl_ext.user_default.sinew.display import frame_times
from bl_ext.user_default.sinew.live import frame, rest, session, x_mirror
from bl_ext.user_default.sinew.scene import rig_pose
from conftest import (
    FLEXOR,
    add_muscle,
    armature_alone,
    bend,
    bind,
    evaluated_points,
    lifts,
    make_arm,
)


@pytest.fixture
def two_arms():
    """((mesh, rig), (mesh, rig)): two bound, bent arms. Frames evaluate "A" before "B"."""
    arms = make_arm("A"), make_arm("B")
    for skin, rig in arms:
        skin.sinew.skin.elastic = False
        add_muscle(rig, around=FLEXOR)
        bind(skin)
        bend(rig, 1.2)
        assert lifts(skin).max() > 5e-4
    return arms


def rests_while_the_other_is_live(skin, other):
    bpy.context.view_layer.update()
    assert np.array_equal(evaluated_points(skin), armature_alone(skin), equal_nan=True)
    assert lifts(other).max() > 5e-4
    return session.reason(skin)


@pytest.mark.parametrize("error", [RuntimeError, AttributeError, KeyError, ValueError, ZeroDivisionError])
@pytest.mark.parametrize("part", ["read_pose", "_read_tension", "_show_tissues", "_skin"])
def test_any_exception_in_one_character_leaves_the_others_live(two_arms, monkeypatch, caplog, error, part):
    (skin, rig), (other, other_rig) = two_arms
    owner = rig_pose if part == "read_pose" else frame
    works = getattr(owner, part)

    def fails(*arguments, **options):
        names = {getattr(argument, "name", "") for argument in arguments if isinstance(argument, bpy.types.ID)}
        empties = [argument for argument in arguments if isinstance(argument, list)]
        names |= {empty.parent.name for empties in empties for empty in empties}
        if names & {skin.name, rig.name}:
            raise error("a broken part")
        return works(*arguments, **options)

    monkeypatch.setattr(owner, part, fails)
    with caplog.at_level(logging.ERROR, logger="sinew"):
        bend(rig, 1.0)
        bend(other_rig, 1.0)
        reason = rests_while_the_other_is_live(skin, other)
    assert "a broken part" in reason and rig.name in reason
    records = [record for record in caplog.records if record.name == "sinew"]
    assert len(records) == 1 and records[0].exc_info and rig.name in records[0].getMessage()
    monkeypatch.undo()
    bend(rig, 1.2)
    assert lifts(skin).max() > 5e-4 and session.reason(skin) == ""


def test_a_failure_that_ended_is_logged_again(two_arms, monkeypatch, caplog):
    (_skin, rig), _other = two_arms
    works = rig_pose.read_pose
    for _time in range(2):
        monkeypatch.setattr(rig_pose, "read_pose", lambda *_: 1 / 0)
        bend(rig, 0.9)
        bend(rig, 0.8)
        monkeypatch.setattr(rig_pose, "read_pose", works)
        bend(rig, 0.7)
    assert sum(rig.name in record.getMessage() for record in caplog.records) == 2


@pytest.mark.parametrize("scale", [(1.0, 0.0, 1.0), (0.0, 1.0, 1.0)])
def test_a_bendy_bone_with_scale_0_leaves_the_others_live(two_arms, scale):
    (skin, rig), (other, _other_rig) = two_arms
    rig.data.bones["lower"].bbone_segments = 3
    bend(rig, 1.1)
    assert lifts(skin).max() > 5e-4
    rig.pose.bones["lower"].scale = scale
    reason = rests_while_the_other_is_live(skin, other)
    assert rig.name in reason and "lower" in reason and "scale of 0" in reason
    rig.pose.bones["lower"].scale = (1.0, 1.0, 1.0)
    bpy.context.view_layer.update()
    assert lifts(skin).max() > 5e-4


@pytest.mark.parametrize(
    ("kind", "domain"), [("FLOAT_COLOR", "POINT"), ("BYTE_COLOR", "CORNER"), ("FLOAT_VECTOR", "FACE"), ("INT", "POINT")]
)
def test_a_converted_correction_attribute_leaves_the_others_live(two_arms, kind, domain):
    (skin, _rig), (other, _other_rig) = two_arms
    skin.data.attributes.remove(skin.data.attributes["sinew_correction"])
    skin.data.attributes.new("sinew_correction", kind, domain)
    skin.data.update()
    bpy.context.view_layer.update()
    assert "sinew_correction" in session.reason(skin)
    assert lifts(other).max() > 5e-4
    skin.data.attributes.remove(skin.data.attributes["sinew_correction"])
    skin.data.update()
    bpy.context.view_layer.update()
    assert lifts(skin).max() > 5e-4


def test_a_failing_skin_leaves_the_other_skin_of_its_rig_live(two_arms, monkeypatch):
    (skin, rig), _other = two_arms
    second, own_rig = make_arm("Second")
    second.modifiers["Armature"].object = second.parent = rig
    bpy.data.objects.remove(own_rig)
    bind(second)
    monkeypatch.setattr(session, "skin_state", _failing_for(skin, session.skin_state))
    bend(rig, 1.1)
    assert "a broken part" in session.reason(skin)
    assert lifts(second).max() > 5e-4 and lifts(skin).max() < 1e-6


def _failing_for(failing, works):
    def fails(skin, *arguments, **options):
        if skin == failing:
            raise RuntimeError("a broken part")
        return works(skin, *arguments, **options)

    return fails


def test_times_end_after_a_failure(two_arms, monkeypatch):
    (_skin, rig), _other = two_arms
    monkeypatch.setattr(rig_pose, "read_pose", lambda *_: 1 / 0)
    frame_times.switch(True)
    try:
        bend(rig, 1.0)
        assert frame_times.means_ms()["total"] > 0.0
    finally:
        frame_times.switch(False)


def test_a_failure_of_x_mirror_leaves_the_skins_live(two_arms, monkeypatch, caplog):
    (skin, rig), _other = two_arms
    rig.sinew.rig.mirror_x = True
    monkeypatch.setattr(x_mirror, "is_on", lambda _rig: 1 / 0)
    before = evaluated_points(skin)
    bend(rig, 0.6)
    assert np.abs(evaluated_points(skin) - before).max() > 1e-3 and lifts(skin).max() > 1e-4
    assert any("X-mirror" in record.getMessage() for record in caplog.records)


def test_a_failure_while_saving_leaves_the_others_saved_at_rest(two_arms, tmp_path, monkeypatch, caplog):
    (skin, _rig), (other, _other_rig) = two_arms
    monkeypatch.setattr(rest, "rest_skin", _failing_for(skin, rest.rest_skin))
    path, name = str(tmp_path / "two.blend"), other.data.name
    bpy.ops.wm.save_as_mainfile(filepath=path, copy=True)
    assert lifts(other).max() > 5e-4
    assert any(skin.name in record.getMessage() for record in caplog.records)
    with bpy.data.libraries.load(path) as (_source, target):
        target.meshes = [name]
    correction = np.empty((len(other.data.vertices), 3), np.float32)
    target.meshes[0].attributes["sinew_correction"].data.foreach_get("vector", correction.reshape(-1))
    assert not correction.any()
