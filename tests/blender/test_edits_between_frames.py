# SPDX-License-Identifier: GPL-3.0-or-later
"""Edits between two frames have an effect in the second. Without edits, Sinew does not read the file again."""

import bpy
import numpy as np
import pytest
from conftest import FLEXOR, add_muscle, bind, evaluated_points, key_bend, select


@pytest.fixture
def playing(arm):
    """(mesh, rig, muscle): an arm with one muscle whose elbow bends from frame 1 to 9, after some frames."""
    skin, rig = arm
    muscle = add_muscle(rig, around=FLEXOR)
    select(rig)
    bpy.ops.sinew.add_tissue(kind="SPHERE", origin_bone="lower")
    bind(skin)
    key_bend(rig, {1: 0.3, 9: 1.7})
    show(3, 4)
    return skin, rig, muscle


def show(*frames):
    for frame in frames:
        bpy.context.scene.frame_set(frame)


def shown_after_binding_again(skin, frame: int) -> np.ndarray:
    """The points of a frame after everything was read again."""
    from bl_ext.user_default.sinew.live import handlers, session
    from bl_ext.user_default.sinew.scene import characters

    session.forget()
    characters.forget()
    handlers.mark_all_dirty()
    show(frame)
    return evaluated_points(skin)


def constraint_of(muscle):
    return muscle.constraints["Sinew Insertion"]


def widen(_skin, _rig, muscle):
    muscle.scale.x *= 1.3


def turn(_skin, _rig, muscle):
    muscle.rotation_euler.x += 0.2


def turn_in_another_order(_skin, _rig, muscle):
    muscle.rotation_euler = (0.3, 0.4, 0.5)
    show(4)
    muscle.rotation_mode = "ZYX"


def show_larger(_skin, _rig, muscle):
    muscle.empty_display_size = 1.2


def lengthen_tendon(_skin, _rig, muscle):
    muscle.sinew.tissue.origin_tendon += 0.02


def keep_less_volume(_skin, _rig, muscle):
    muscle.sinew.tissue.volume_keeping = 0.2


def tense(_skin, _rig, muscle):
    muscle.sinew.tissue.tension = 1.0


def key_tension(_skin, _rig, muscle):
    for frame, tension in ((1, 0.0), (5, 1.0)):
        muscle.sinew.tissue.tension = tension
        muscle.sinew.tissue.keyframe_insert("tension", frame=frame)


def key_tendon(_skin, _rig, muscle):
    for frame, length in ((1, 0.0), (5, 0.05)):
        muscle.sinew.tissue.origin_tendon = length
        muscle.sinew.tissue.keyframe_insert("origin_tendon", frame=frame)


def key_muscle_influence(skin, _rig, _muscle):
    for frame, gain in ((1, 1.0), (5, 3.0)):
        skin.sinew.skin.muscle_influence = gain
        skin.sinew.skin.keyframe_insert("muscle_influence", frame=frame)


def drive_width(_skin, _rig, muscle):
    muscle.driver_add("scale", 0).driver.expression = f"{muscle.scale.x} * 1.4"


def insert_elsewhere(_skin, _rig, muscle):
    constraint_of(muscle).subtarget = "upper"


def originate_elsewhere(_skin, _rig, muscle):
    muscle.sinew.tissue.origin_bone = "lower"


def parent_to_another_bone(_skin, _rig, muscle):
    muscle.parent_bone = "lower"


def make_stuffing(_skin, _rig, muscle):
    muscle.sinew.tissue.kind = "STUFFING"


def wrap(_skin, _rig, muscle):
    muscle.sinew.tissue.wraps.add().sphere = next(found for found in bpy.data.objects if found.sinew.tissue.kind == "SPHERE")


def rename_and_widen(_skin, _rig, muscle):
    muscle.name = "Another"
    muscle.scale.x *= 1.3


def add_objects_and_widen(_skin, _rig, muscle):
    for name in ("AAA", "zzz"):
        bpy.data.objects.new(name, None)  # not linked, so that Blender does not evaluate it
    muscle.scale.x *= 1.3


def delete(_skin, _rig, muscle):
    bpy.data.objects.remove(muscle)


def disable(_skin, _rig, muscle):
    muscle.sinew.tissue.tension = 0.5
    muscle.hide_viewport = True


def lower_muscle_influence(skin, _rig, _muscle):
    skin.sinew.skin.muscle_influence = 2.0


def set_bone(_skin, rig, _muscle):
    rig.pose.bones["lower"].sinew.muscle_influence = 2.0


def move_bone(_skin, rig, _muscle):
    select(rig)
    bpy.ops.object.mode_set(mode="EDIT")
    rig.data.edit_bones["lower"].head.y += 0.01
    bpy.ops.object.mode_set(mode="OBJECT")


def stop_deforming(_skin, rig, _muscle):
    rig.data.bones["lower"].use_deform = False


def move_vertices(skin, _rig, _muscle):
    points = np.empty(3 * len(skin.data.vertices), np.float32)
    skin.data.vertices.foreach_get("co", points)
    skin.data.vertices.foreach_set("co", points * np.float32(1.01))


def weigh(skin, _rig, _muscle):
    skin.vertex_groups["upper"].add(range(300), 0.3, "REPLACE")


def paint(skin, _rig, _muscle):
    attribute = skin.data.attributes.new("sinew_muscle_influence", "FLOAT", "POINT")
    attribute.data.foreach_set("value", np.full(len(skin.data.vertices), 2.0, np.float32))


def preserve_volume(skin, _rig, _muscle):
    skin.sinew.skin.elastic = False  # Sinew compensates the modifier's change
    show(4)
    skin.modifiers["Armature"].use_deform_preserve_volume = True


def rename_group(skin, _rig, _muscle):
    skin.vertex_groups["lower"].name = "nothing"


def scale_mesh_object(skin, _rig, _muscle):
    skin.scale.x = 1.1


EDITS = (
    widen, turn, turn_in_another_order, show_larger, lengthen_tendon, keep_less_volume, tense, key_tension, key_tendon,
    key_muscle_influence, drive_width, insert_elsewhere, originate_elsewhere, parent_to_another_bone, make_stuffing, wrap,
    rename_and_widen, add_objects_and_widen, delete, disable, lower_muscle_influence, set_bone, move_bone, stop_deforming,
    move_vertices, weigh, paint, preserve_volume, rename_group, scale_mesh_object,
)  # fmt: skip


@pytest.mark.parametrize("edit", EDITS, ids=lambda edit: edit.__name__)
def test_an_edit_has_an_effect_in_the_next_frame(playing, edit):
    skin, _rig, _muscle = playing
    show(5)
    before = evaluated_points(skin)
    show(4)
    edit(*playing)
    show(5)
    points = evaluated_points(skin)
    assert np.abs(points - before).max() > 1e-6
    assert np.array_equal(points, shown_after_binding_again(skin, 5))
    show(6)
    assert np.array_equal(evaluated_points(skin), shown_after_binding_again(skin, 6))


@pytest.mark.parametrize("edit", ["scale", "volume_keeping", "muscle_influence"])
def test_edits_of_a_script_at_every_frame_have_an_effect(playing, edit):
    skin, _rig, muscle = playing
    name, width = muscle.name, muscle.scale.x

    def move(scene, *_):
        muscle = bpy.data.objects[name]
        if edit == "scale":
            muscle.scale.x = width * (1.0 + 0.1 * scene.frame_current)
        else:
            is_tissue = edit == "volume_keeping"
            settings = muscle.sinew.tissue if is_tissue else bpy.data.objects["Arm"].sinew.skin
            setattr(settings, edit, 0.1 * scene.frame_current)

    bpy.app.handlers.frame_change_post.insert(0, move)
    try:
        for frame in (5, 6, 7):
            show(frame)
            points = evaluated_points(skin)
            assert np.array_equal(points, shown_after_binding_again(skin, frame))
    finally:
        bpy.app.handlers.frame_change_post.remove(move)


def test_without_an_edit_nothing_is_read_again(playing, monkeypatch):
    from bl_ext.user_default.sinew.live import session, tissue_snapshot
    from bl_ext.user_default.sinew.scene import bone_weights, mesh_arrays

    skin, rig, _muscle = playing
    show(5)

    def read_again(*_):
        raise AssertionError("read again")

    for module, name in (
        (tissue_snapshot, "settings_of"), (tissue_snapshot, "transforms_of"), (session, "read_musculature"),
        (mesh_arrays, "read_points"), (bone_weights, "read_weights"),
    ):  # fmt: skip
        monkeypatch.setattr(module, name, read_again)
    show(6, 7)
    rig.pose.bones["upper"].rotation_quaternion = (0.9, 0.1, 0.0, 0.0)
    bpy.context.view_layer.update()
    points = evaluated_points(skin)
    monkeypatch.undo()
    assert np.array_equal(points, shown_after_binding_again_without_keys(skin))


def shown_after_binding_again_without_keys(skin) -> np.ndarray:
    """The points of the current pose after everything was read again."""
    from bl_ext.user_default.sinew.live import handlers, session
    from bl_ext.user_default.sinew.scene import characters

    session.forget()
    characters.forget()
    handlers.mark_all_dirty()
    skin.update_tag()
    bpy.context.view_layer.update()
    return evaluated_points(skin)


def test_removed_objects_do_not_hide_an_edit(playing):
    """Objects that Blender lists before an evaluation may be removed already."""
    skin, _rig, _muscle = playing
    for frame in range(5, 25):
        other = bpy.data.objects.new("Other", None)
        bpy.context.scene.collection.objects.link(other)
        bpy.context.view_layer.update()
        other.location.x = 1.0
        bpy.data.objects.remove(other)
        show(frame)
    assert np.array_equal(evaluated_points(skin), shown_after_binding_again(skin, 24))
