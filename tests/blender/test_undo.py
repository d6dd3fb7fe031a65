# SPDX-License-Identifier: GPL-3.0-or-later
"""Undo and redo of a pose, a bind and Edit Rest Pose. The undo of other operators is tested with the operator."""

import bpy
import numpy as np
import pytest
from bl_ext.user_default.sinew.live import handlers, session
from bl_ext.user_default.sinew.scene import characters
from conftest import FLEXOR, add_muscle, bend, bind, evaluated_points, select


def test_undo_and_redo(bent_skin):
    skin, rig = bent_skin
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
    skin = bpy.data.objects["Arm"]
    assert skin.sinew.skin.bound and "Sinew" in [modifier.name for modifier in skin.modifiers]


def test_edit_rest_pose_is_undone(arm):
    _skin, rig = arm
    add_muscle(rig)
    select(rig)
    bpy.ops.ed.undo_push(message="before")
    bpy.ops.sinew.edit_rest_pose()
    bpy.ops.ed.undo_push(message="rest")
    bpy.ops.ed.undo()
    assert bpy.data.armatures["Arm Rig"].pose_position == "POSE"


def count_binds(monkeypatch) -> list:
    binds = []
    bind_again = session.bind
    monkeypatch.setattr(session, "bind", lambda *arguments: binds.append(1) or bind_again(*arguments))
    return binds


def equals_fresh(name="Arm"):
    """Whether the points are those after everything was read again."""
    points = evaluated_points(bpy.data.objects[name])
    session.forget()
    characters.forget()
    handlers.mark_all_dirty()
    bpy.data.objects[name].update_tag()
    bpy.context.view_layer.update()
    return np.array_equal(points, evaluated_points(bpy.data.objects[name]))


def test_undo_of_a_pose_binds_nothing_again(bent_skin, monkeypatch):
    _skin, rig = bent_skin
    rig.pose.bones["lower"].sinew.muscle_influence = 1.5
    bpy.context.view_layer.update()
    bpy.ops.ed.undo_push(message="bent")
    bend(rig, 0.4)
    bpy.ops.ed.undo_push(message="less")
    binds = count_binds(monkeypatch)
    for _ in range(3):
        bpy.ops.ed.undo()
        bpy.ops.ed.redo()
    assert binds == []
    monkeypatch.undo()
    assert equals_fresh()


def move_vertex(skin, _rig):
    skin.data.vertices[7].co.z += 0.01


def weigh(skin, _rig):
    skin.vertex_groups["upper"].add(range(300), 0.3, "REPLACE")


def unparent_bone(_skin, rig):
    select(rig)
    bpy.ops.object.mode_set(mode="EDIT")
    rig.data.edit_bones["lower"].parent = None
    bpy.ops.object.mode_set(mode="OBJECT")


def widen(_skin, _rig):
    bpy.data.objects["Muscle lower"].scale.x *= 1.3


def set_bone_factor(_skin, rig):
    rig.pose.bones["lower"].sinew.muscle_influence = 3.0


def delete_face(skin, _rig):
    select(skin)
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.ops.mesh.select_all(action="DESELECT")
    bpy.ops.object.mode_set(mode="OBJECT")
    skin.data.polygons[200].select = True
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.ops.mesh.delete(type="ONLY_FACE")
    bpy.ops.object.mode_set(mode="OBJECT")


@pytest.mark.parametrize(
    "edit", (move_vertex, weigh, unparent_bone, widen, set_bone_factor, delete_face), ids=lambda edit: edit.__name__
)
def test_undo_and_redo_of_what_a_bind_depends_on(bent_skin, edit):
    bpy.ops.ed.undo_push(message="before")
    before = evaluated_points(bpy.data.objects["Arm"])
    edit(*bent_skin)
    bpy.context.view_layer.update()
    bpy.ops.ed.undo_push(message="edited")
    after = evaluated_points(bpy.data.objects["Arm"])
    bpy.ops.ed.undo()
    assert np.array_equal(evaluated_points(bpy.data.objects["Arm"]), before)
    bpy.ops.ed.redo()
    assert np.array_equal(evaluated_points(bpy.data.objects["Arm"]), after)
    assert equals_fresh()
    bpy.ops.ed.undo()
    assert equals_fresh()


def test_a_stroke_that_no_bind_depends_on_binds_nothing_again(bent_skin, monkeypatch):
    skin, _rig = bent_skin
    other = skin.vertex_groups.new(name="Hair Density")
    bpy.context.view_layer.update()
    bpy.ops.ed.undo_push(message="group")
    binds = count_binds(monkeypatch)
    for weight in (0.2, 0.7):
        other.add(range(100), weight, "REPLACE")
        skin.data.update()
        bpy.context.view_layer.update()
        bpy.ops.ed.undo_push(message="stroke")
    bpy.ops.ed.undo()
    assert binds == []
    monkeypatch.undo()
    assert equals_fresh()
