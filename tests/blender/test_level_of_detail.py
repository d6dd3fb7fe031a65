# SPDX-License-Identifier: GPL-3.0-or-later
"""Less of a skin is computed far from the camera, and as set for viewport and renders. The frame alone says how much."""

import bpy
import numpy as np
import pytest
from bl_ext.user_default.sinew.live import handlers, session
from bl_ext.user_default.sinew.scene import characters, current_frame
from conftest import FLEXOR, add_muscle, armature_alone, bend, bind, evaluated_points
from evaluations import rendered


@pytest.fixture
def elastic(arm):
    """(mesh, rig): a bound, bent, elastic arm, and a camera 10 m from it."""
    skin, rig = arm
    add_muscle(rig, around=FLEXOR)
    bind(skin)
    bend(rig, 1.2)
    camera = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
    bpy.context.scene.collection.objects.link(camera)
    camera.location = (0.3, -10.0, 0.0)
    bpy.context.scene.camera = camera
    bpy.context.view_layer.update()
    return skin, rig


def set_skin(skin, **settings):
    for name, value in settings.items():
        setattr(skin.sinew.skin, name, value)
    bpy.context.view_layer.update()


def points_with(skin, **settings) -> np.ndarray:
    """The points with some settings, which are then as before."""
    before = {name: getattr(skin.sinew.skin, name) for name in settings}
    set_skin(skin, **settings)
    points = evaluated_points(skin)
    set_skin(skin, **before)
    return points


def move_camera(distance):
    bpy.context.scene.camera.location.y = -distance
    bpy.context.view_layer.update()
    bpy.context.scene.frame_set(bpy.context.scene.frame_current)


def test_levels(elastic):
    skin, _rig = elastic
    full, not_elastic = evaluated_points(skin), points_with(skin, elastic=False)
    alone = armature_alone(skin)
    assert np.abs(full - not_elastic).max() > 1e-4 and np.abs(not_elastic - alone).max() > 1e-4
    assert np.array_equal(points_with(skin, viewport_detail="ANCHORS"), not_elastic)
    assert np.array_equal(points_with(skin, viewport_detail="ARMATURE"), alone)
    assert np.array_equal(evaluated_points(skin), full)


def test_distance(elastic):
    skin, rig = elastic
    full, not_elastic = evaluated_points(skin), points_with(skin, elastic=False)
    alone = armature_alone(skin)
    rig.keyframe_insert("location", frame=1)
    set_skin(skin, elastic_distance=5.0, muscle_distance=20.0)
    for distance, expected in ((4.0, full), (6.0, not_elastic), (25.0, alone), (6.0, not_elastic), (4.0, full)):
        move_camera(distance)
        assert np.array_equal(evaluated_points(skin), expected)


def test_the_level_is_that_of_the_frame_alone(elastic):
    skin, _rig = elastic
    camera = bpy.context.scene.camera
    for frame, distance in ((1, 2.0), (11, 42.0)):
        camera.location.y = -distance
        camera.keyframe_insert("location", frame=frame)
    set_skin(skin, elastic_distance=9.0, muscle_distance=30.0)
    shown = {}
    for frame in (1, 2, 3, 4, 8, 9, 3, 2, 10):
        bpy.context.scene.frame_set(frame)
        shown.setdefault(frame, []).append(evaluated_points(skin))
    assert len({points[0].tobytes() for points in shown.values()}) == 3
    for frame, points in shown.items():
        session.forget()
        characters.forget()
        handlers.mark_all_dirty()
        bpy.context.scene.frame_set(frame)
        assert all(np.array_equal(evaluated_points(skin), found) for found in points)


def test_a_switch_of_the_level_binds_once(elastic, monkeypatch):
    skin, _rig = elastic
    set_skin(skin, elastic_distance=5.0)
    binds = []
    bind_again = session.bind
    monkeypatch.setattr(session, "bind", lambda *arguments: binds.append(1) or bind_again(*arguments))
    for distance in (4.0, 6.0, 4.0, 6.0, 4.0):
        move_camera(distance)
    assert len(binds) <= 1


def test_viewport_and_render_are_set_apart(elastic, tmp_path):
    skin, _rig = elastic
    ten, two, not_elastic = evaluated_points(skin), points_with(skin, iterations=2), points_with(skin, elastic=False)
    assert np.abs(ten - two).max() > 1e-6
    set_skin(skin, iterations=2, render_iterations=10)
    assert np.array_equal(evaluated_points(skin), two)
    assert np.array_equal(rendered(skin, tmp_path, 1)[0], ten)
    set_skin(skin, render_detail="ANCHORS")
    assert np.array_equal(rendered(skin, tmp_path, 1)[0], not_elastic)
    set_skin(skin, render_detail="FULL", viewport_detail="ARMATURE", render_iterations=0)
    assert np.array_equal(rendered(skin, tmp_path, 1)[0], two)


def test_bakes_have_full_detail(elastic):
    skin, rig = elastic
    ten = evaluated_points(skin)
    rig.pose.bones["lower"].keyframe_insert("rotation_euler", frame=1)
    set_skin(skin, iterations=2, render_iterations=10, viewport_detail="ARMATURE", elastic_distance=1.0)
    with current_frame.visit_frames(bpy.context.scene) as go_to:
        go_to(1)
        assert np.array_equal(evaluated_points(skin), ten)
    assert np.array_equal(evaluated_points(skin), armature_alone(skin))
