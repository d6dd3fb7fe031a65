# SPDX-License-Identifier: GPL-3.0-or-later
"""The panel shows what can be done next, repairs what it names, and says why an operator is greyed out."""

import bpy
import pytest
from bl_ext.user_default.sinew.live import session
from bl_ext.user_default.sinew.ui import next_step, problems
from bl_ext.user_default.sinew.ui.sidebar import context_character, rig_and_reason
from conftest import add_muscle, bend, bind, lifted, select
from test_panels import draw_all, texts


def state():
    rig, _reason = rig_and_reason(bpy.context)
    return next_step.of(bpy.context, rig)


def shown_problems():
    rig, _reason = rig_and_reason(bpy.context)
    return problems.of(bpy.context, rig, context_character(bpy.context))


def buttons(drawn):
    return [entry[1] for entry in drawn if entry[0] == "operator"]


def test_the_steps_follow_each_other(arm):
    skin, rig = arm
    bpy.context.view_layer.objects.active = None
    assert state() == next_step.NO_CHARACTER and "Arm Rig" in texts(draw_all())
    bpy.ops.sinew.repair(what="ACTIVATE", name="Arm Rig")
    assert bpy.context.object == rig and rig.select_get()
    assert state() == next_step.RIG and "sinew.bind" not in buttons(draw_all())
    add_muscle(rig)
    select(rig)
    assert state() == next_step.MUSCLES and "sinew.bind" in buttons(draw_all())
    assert "sinew.bake_shape_keys" not in buttons(draw_all())
    bind(skin)
    assert state() == next_step.BOUND and "sinew.bake_shape_keys" in buttons(draw_all())
    bpy.ops.sinew.repair(what="POSE_MODE", name="Arm Rig")
    assert bpy.context.object == rig and rig.mode == "POSE" and state() == next_step.BOUND
    draw_all()


def test_an_empty_file_says_how_to_get_a_character():
    assert state() == next_step.NO_FILE
    assert any(name.startswith(("wm.fbx", "import_scene.")) for name in buttons(draw_all()))


def reason_of(name):
    """The message of an operator that is greyed out, or an empty text."""
    if getattr(bpy.ops.sinew, name).poll():
        return ""
    with pytest.raises(RuntimeError) as error:
        getattr(bpy.ops.sinew, name)()
    return str(error.value)


NEED_TISSUES = ("bind", "fit", "mirror", "grow_skin", "save_musculature")
NEED_SKINS = ("unbind", "bake_shape_keys", "bake_correctives", "bake_cache", "bake_bones")


def test_greyed_operators_say_why(arm):
    skin, rig = arm
    select(rig)
    assert all("no muscles" in reason_of(name) for name in NEED_TISSUES)
    assert all("Bind Skin" in reason_of(name) for name in NEED_SKINS)
    add_muscle(rig)
    select(skin)
    assert not any(reason_of(name) for name in NEED_TISSUES)
    assert all("Bind Skin" in reason_of(name) for name in NEED_SKINS)
    bind(skin)
    assert not any(reason_of(name) for name in NEED_SKINS)
    skin.modifiers.remove(skin.modifiers["Armature"])
    skin.parent = None
    assert "follows no armature" in reason_of("bind")


def break_edit_mode(_skin, rig):
    select(rig)
    bpy.ops.object.mode_set(mode="EDIT")


def break_rest(_skin, rig):
    select(rig)
    bpy.ops.sinew.edit_rest_pose()


def break_modifier(skin, _rig):
    skin.modifiers.remove(next(found for found in skin.modifiers if found.type == "NODES"))


def break_mesh(skin, rig):
    other = skin.copy()
    bpy.context.scene.collection.objects.link(other)
    other.location.x += 0.3


def break_bone(_skin, rig):
    bpy.data.objects["Biceps"].sinew.tissue.insertion_bone = "gone"


def break_live(skin, _rig):
    skin.sinew.skin.live = False


@pytest.mark.parametrize(
    ("damage", "repair"),
    [
        (break_edit_mode, "LEAVE_EDIT_MODE"),
        (break_rest, "SHOW_POSE"),
        (break_modifier, "BIND_AGAIN"),
        (break_mesh, "SINGLE_USER"),
        (break_live, "LIVE"),
    ],
)
def test_each_problem_has_a_button_that_repairs_it(arm, damage, repair):
    skin, rig = arm
    add_muscle(rig, name="Biceps", around=-1.5)
    bind(skin)
    bend(rig, 1.0)
    assert len(lifted(skin)) > 10 and shown_problems() == []
    damage(skin, rig)
    bpy.context.view_layer.update()
    rig.update_tag()
    bpy.context.view_layer.update()
    found = [problem for problem in shown_problems() if problem.repair == repair]
    assert len(found) == 1 and repair in repr(found)
    draw_all()
    bpy.ops.sinew.repair(what=found[0].repair, name=found[0].name)
    bpy.context.view_layer.update()
    rig.update_tag()
    bpy.context.view_layer.update()
    assert [problem for problem in shown_problems() if problem.repair == repair] == []
    assert not session.reason(skin)


def test_a_tissue_with_a_problem_is_selected(arm):
    skin, rig = arm
    add_muscle(rig, name="Biceps")
    break_bone(skin, rig)
    bpy.context.view_layer.update()
    select(rig)
    (problem,) = shown_problems()
    bpy.ops.sinew.repair(what=problem.repair, name=problem.name)
    assert bpy.context.object.name == "Biceps"


def test_a_repair_of_something_that_is_gone_is_an_error(arm):
    with pytest.raises(RuntimeError, match="Nothing is not in this view layer"):
        bpy.ops.sinew.repair(what="ACTIVATE", name="Nothing")
