# SPDX-License-Identifier: GPL-3.0-or-later
"""A frame evaluates each mesh once: the correction is written before the evaluation, for the pose that a scout has."""

import bpy
import numpy as np
import pytest
from bl_ext.user_default.sinew.display import frame_times, timing_overlay
from bl_ext.user_default.sinew.live import forecast, handlers, session
from bl_ext.user_default.sinew.scene import characters, correction_modifier, scout
from conftest import (
    FLEXOR,
    add_muscle,
    bend,
    bind,
    evaluated_points,
    key_bend,
    lifts,
    link_character,
    make_arm,
    save_character,
)


def play_arm(skin, rig):
    """An arm whose elbow bends from frame 1 to 9, at frame 4 after some others. Returns its muscle."""
    muscle = add_muscle(rig, around=FLEXOR)
    bind(skin)
    key_bend(rig, {1: 0.3, 9: 1.7})
    show(2, 3, 4)
    return muscle


@pytest.fixture
def playing(arm):
    """(mesh, rig, muscle)"""
    return *arm, play_arm(*arm)


def show(*frames):
    for frame in frames:
        bpy.context.scene.frame_set(frame)


@pytest.fixture
def writes(monkeypatch):
    """A function that runs an action and returns when corrections were written: "before" or "after" the evaluation."""
    monkeypatch.setattr(forecast, "_LONG_SECONDS", float("inf"))  # this machine may be busy
    order = []
    write = correction_modifier.write_correction

    def noted(mesh, correction):
        order.append("write")
        write(mesh, correction)

    monkeypatch.setattr(correction_modifier, "write_correction", noted)
    for name in ("frame_change_post", "depsgraph_update_post"):
        getattr(bpy.app.handlers, name).insert(0, lambda *_: order.append("evaluated"))

    def of(action) -> list[str]:
        order.clear()
        action()
        first = order.index("evaluated") if "evaluated" in order else len(order)
        return ["before" if at < first else "after" for at, event in enumerate(order) if event == "write"]

    yield of
    for name in ("frame_change_post", "depsgraph_update_post"):
        del getattr(bpy.app.handlers, name)[0]


def shown_after_binding_again(skin, frame: int) -> np.ndarray:
    forecast.forget()
    session.forget()
    characters.forget()
    handlers.mark_all_dirty()
    show(frame)
    return evaluated_points(skin)


def test_a_frame_writes_its_correction_before_the_evaluation(playing, writes):
    skin, _rig, _muscle = playing
    assert writes(lambda: show(5)) == ["before"]
    points = evaluated_points(skin)
    assert lifts(skin).max() > 5e-4
    assert np.array_equal(points, shown_after_binding_again(skin, 5))


def test_subframes_and_time_remapping(playing, writes):
    skin, _rig, _muscle = playing
    scene = bpy.context.scene
    assert writes(lambda: scene.frame_set(5, subframe=0.375)) == ["before"]
    scene.render.frame_map_new = 200
    show(6)
    assert writes(lambda: show(7)) == ["before"]
    assert np.array_equal(evaluated_points(skin), shown_after_binding_again(skin, 7))


def test_a_pose_by_hand_writes_its_correction_before_the_evaluation(playing, writes):
    skin, rig, _muscle = playing
    rig.animation_data_clear()
    bend(rig, 0.5)
    assert writes(lambda: bend(rig, 0.9)) == ["before"]
    before = evaluated_points(skin)
    handlers.mark_all_dirty()
    bend(rig, 0.9)
    assert np.array_equal(evaluated_points(skin), before)


def test_a_pose_that_follows_an_object_moved_by_hand(playing, writes):
    skin, rig, _muscle = playing
    rig.animation_data_clear()
    target = bpy.data.objects.new("Target", None)
    bpy.context.scene.collection.objects.link(target)
    rig.pose.bones["lower"].constraints.new("COPY_ROTATION").target = target
    bpy.context.view_layer.update()

    def turn(angle):
        target.rotation_euler.z = angle
        bpy.context.view_layer.update()

    turn(0.4)
    assert writes(lambda: turn(0.8)) == ["before"]
    assert lifts(skin).max() > 5e-4


def test_a_keyed_tension_is_expected_and_a_driven_one_is_read(playing, writes):
    skin, _rig, muscle = playing
    for frame, tension in ((1, 0.0), (9, 1.0)):
        muscle.sinew.tissue.tension = tension
        muscle.sinew.tissue.keyframe_insert("tension", frame=frame)
    show(3, 4, 5)  # the first forecast with new keys has a new scout and is wrong; it pauses for one frame
    assert writes(lambda: show(6)) == ["before"]
    assert np.array_equal(evaluated_points(skin), shown_after_binding_again(skin, 6))
    muscle.animation_data_clear()
    muscle.driver_add("sinew.tissue.tension").driver.expression = "frame / 10"
    show(7)
    assert writes(lambda: show(8)) == ["after"]
    assert np.array_equal(evaluated_points(skin), shown_after_binding_again(skin, 8))


def test_bones_that_depend_on_the_mesh_need_two_evaluations(playing, writes):
    skin, rig, _muscle = playing
    frame_times.switch(True)
    try:
        group = skin.vertex_groups.new(name="hand")
        group.add([10], 1.0, "REPLACE")
        follow = rig.pose.bones["upper"].constraints.new("COPY_LOCATION")
        follow.target, follow.subtarget, follow.influence = skin, "hand", 0.1
        show(3, 4, 6)
        assert writes(lambda: show(5)) == ["after"]
        show(6)
        assert f"Evaluations: 2 ({rig.name}: its bones depend on a bound mesh)" in timing_overlay.lines()
    finally:
        frame_times.switch(False)


def test_a_pose_that_the_scout_can_not_know_is_computed_again(playing, writes):
    """The location of a bone is that of the scene's cursor: in another scene, the cursor is elsewhere."""
    skin, rig, _muscle = playing
    bone = rig.pose.bones["lower"]
    bone.rotation_euler = (0.0, 0.0, 1.0)
    driver = bone.driver_add("rotation_euler", 0).driver
    variable = driver.variables.new()
    variable.name, variable.type = "x", "CONTEXT_PROP"
    variable.targets[0].context_property = "ACTIVE_SCENE"
    variable.targets[0].data_path = "cursor.location[0]"
    driver.expression = "x"
    bpy.context.scene.cursor.location.x = 0.5
    show(3, 4, 5)
    points = [evaluated_points(skin) for frame in (6, 7, 8) if show(frame) is None]
    for frame, shown in zip((6, 7, 8), points):
        assert np.array_equal(shown, shown_after_binding_again(skin, frame))


def test_wrong_forecasts_pause(playing, writes, monkeypatch):
    skin, _rig, _muscle = playing
    read = forecast.rig_pose.read_pose

    def wrong(evaluated_rig, rest, pose):
        read(evaluated_rig, rest, pose)
        pose[0, 3, 0] += 0.01 * np.random.default_rng().random()

    monkeypatch.setattr(forecast, "rig_pose", type("", (), {"read_pose": staticmethod(wrong)}))
    counted = [writes(lambda frame=frame: show(frame)) for frame in (1, 3, 5, 7, 9, 2, 4, 6)]
    assert counted.count(["before", "after"]) == 3 and counted.count(["after"]) == 5
    points = evaluated_points(skin)
    monkeypatch.undo()
    assert np.array_equal(points, shown_after_binding_again(skin, 6))


def test_another_handler_that_poses_bones_after_the_forecast(playing):
    skin, rig, _muscle = playing

    def poses(scene, *_):
        rig.pose.bones["upper"].rotation_quaternion = (1.0, 0.0, 0.1 * scene.frame_current, 0.0)

    bpy.app.handlers.frame_change_pre.append(poses)
    try:
        show(5, 6)
        points = evaluated_points(skin)
        assert np.array_equal(points, shown_after_binding_again(skin, 6))
    finally:
        bpy.app.handlers.frame_change_pre.remove(poses)


def test_others_do_not_see_the_scout(playing, tmp_path):
    _skin, rig, _muscle = playing
    seen, users = [], rig.users
    lists = [getattr(bpy.app.handlers, name) for name in handlers._AROUND_EVALUATIONS]
    for registered in lists:
        registered.append(lambda scene, *_: seen.append(scene.name))
    try:
        show(5, 6)
        bend(rig, 0.2, "upper")
    finally:
        for registered in lists:
            registered.pop()
    assert scout._open
    assert set(seen) == {bpy.context.scene.name} == set(bpy.data.scenes.keys())
    assert rig.users == users and len(rig.users_scene) == 1
    names = set(bpy.data.objects.keys())
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "saved.blend"), copy=True)
    with bpy.data.libraries.load(str(tmp_path / "saved.blend")) as (saved, _target):
        assert saved.scenes == bpy.data.scenes.keys() and set(saved.objects) == names


def test_deleting_undoing_and_loading_while_the_scout_is_open(playing, tmp_path):
    skin, rig, _muscle = playing
    other_skin, other_rig = make_arm("Other")
    play_arm(other_skin, other_rig)
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "two.blend"), copy=True)
    show(5)
    bpy.ops.ed.undo_push(message="before")
    rig.location.x = 1.0
    show(6)
    bpy.ops.ed.undo_push(message="after")
    show(7)
    bpy.ops.ed.undo()
    show(8, 5)
    skin, rig, other_skin = (bpy.data.objects[name] for name in ("Arm", "Arm Rig", "Other"))
    assert lifts(skin).max() > 5e-4
    bpy.data.objects.remove(rig)
    show(6, 7)
    assert lifts(other_skin).max() > 5e-4
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "two.blend"))
    show(5, 6)
    assert lifts(bpy.data.objects["Arm"]).max() > 5e-4


def test_a_linked_character_stays_linked_indirectly_and_an_override_is_expected(playing, writes, tmp_path):
    path = str(tmp_path / "library.blend")
    save_character(path)
    skin, _rig = link_character(path)
    show(2, 3, 4)
    assert writes(lambda: show(5)) == ["before"]
    assert np.array_equal(evaluated_points(skin), shown_after_binding_again(skin, 5))
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    with bpy.data.libraries.load(path, link=True) as (_source, target):
        target.collections = ["Character"]
    instance = bpy.data.objects.new("Instance", None)
    instance.instance_type, instance.instance_collection = "COLLECTION", target.collections[0]
    bpy.context.scene.collection.objects.link(instance)
    show(2)
    indirect = [found.name for found in bpy.data.objects if found.is_library_indirect]
    show(3, 4, 5)
    assert [found.name for found in bpy.data.objects if found.is_library_indirect] == indirect
    assert session.cached_rig(next(found for found in bpy.data.objects if found.type == "ARMATURE"))
