# SPDX-License-Identifier: GPL-3.0-or-later
"""The elastic skin in Blender: a bent elbow keeps its volume, and everything else stays the same."""

import bpy
import numpy as np
import pytest
from conftest import (
    FLEXOR,
    add_muscle,
    armature_alone,
    bend,
    bind,
    evaluated_points,
    key_bend,
    make_arm,
    rest_points,
    select,
)


def volume(skin, points):
    """The volume of the arm, closed by fans at its open ends."""
    skin.data.calc_loop_triangles()
    corners = (points - points.mean(axis=0))[np.array([t.vertices for t in skin.data.loop_triangles])]
    total = np.einsum("ij,ij->", corners[:, 0], np.cross(corners[:, 1], corners[:, 2]))
    rings = points.reshape(24, 20, 3) - points.mean(axis=0)
    for ring, sign in ((rings[0], 1.0), (rings[-1], -1.0)):
        total += sign * np.einsum("ij,ij->", np.roll(ring, -1, axis=0), np.cross(ring, ring.mean(axis=0)[None]))
    return abs(total) / 6.0


def make_elastic(arm):
    skin, rig = arm
    add_muscle(rig, around=FLEXOR)
    assert skin.sinew.skin.elastic
    bind(skin)
    return skin, rig


def test_a_bent_elbow_keeps_its_volume(arm):
    skin, rig = make_elastic(arm)
    rest = volume(skin, rest_points(skin))
    bend(rig, 1.8)
    assert abs(volume(skin, evaluated_points(skin)) / rest - 1.0) < 0.02
    assert volume(skin, armature_alone(skin)) / rest < 0.96


def test_the_rest_pose_does_not_change_and_off_means_off(arm):
    skin, rig = make_elastic(arm)
    assert np.abs(evaluated_points(skin) - rest_points(skin)).max() <= 1e-6
    bend(rig, 1.2)
    elastic = evaluated_points(skin)
    skin.sinew.skin.elastic = False
    bpy.context.view_layer.update()
    assert np.linalg.norm(evaluated_points(skin) - elastic, axis=1).max() > 2e-3


@pytest.mark.parametrize(("name", "value"), [("contacts", False), ("energy", "SPRINGS"), ("iterations", 2)])
def test_a_switch_reaches_the_skin_and_back(arm, name, value):
    """At this bend, skin touches other skin."""
    skin, rig = arm
    make_elastic(arm)
    bend(rig, 2.75)
    before, usual = evaluated_points(skin), getattr(skin.sinew.skin, name)
    setattr(skin.sinew.skin, name, value)
    bpy.context.view_layer.update()
    assert np.abs(evaluated_points(skin) - before).max() > 1e-5
    setattr(skin.sinew.skin, name, usual)
    bpy.context.view_layer.update()
    assert np.array_equal(evaluated_points(skin), before)


@pytest.mark.parametrize("scale", [0.01, 100.0])
def test_the_size_of_the_objects_does_not_matter(scale):
    """An arm in an armature object and a mesh object of another scale deforms the same in its own space."""
    found = []
    for name, size in (("Plain", 1.0), ("Scaled", scale)):
        skin, rig = make_arm(name)
        rig.scale = (size,) * 3
        bpy.context.view_layer.update()
        make_elastic((skin, rig))
        bend(rig, 1.8)
        found.append(evaluated_points(skin))
    assert np.abs(found[0] - rest_points(bpy.data.objects["Plain"])).max() > 0.1
    assert np.abs(found[1] - found[0]).max() < 1e-5


@pytest.mark.slow
def test_200000_vertices(arm):
    """The arm subdivided into 200,000 vertices binds and plays a frame."""
    skin, rig = make_arm("Fine", rings=1000, around=200)
    assert len(skin.data.vertices) == 200_000
    make_elastic((skin, rig))
    bend(rig, 1.8)
    points = evaluated_points(skin)
    assert np.isfinite(points).all()
    assert np.linalg.norm(points - armature_alone(skin), axis=1).max() > 5e-3
    bend(rig, 0.0)
    assert np.abs(evaluated_points(skin) - rest_points(skin)).max() <= 1e-6


def test_the_elastic_skin_bakes_as_live(arm):
    skin, rig = make_elastic(arm)
    key_bend(rig, {1: 0.0, 5: 2.2})
    select(skin)
    bpy.ops.sinew.bake_shape_keys(frame_start=1, frame_end=5, step=1, prefix="sinew_")
    assert skin.sinew.skin.bake_error_mm < 1e-3


def test_split_bones_are_one_segment(real_body):
    from bl_ext.user_default.sinew.scene import rig_pose

    _skin, rig = real_body
    rest = rig_pose.read_rest(rig)
    segment = {name: rest.segments[index] for name, index in rest.index_of_bone.items()}
    for first, second in (("upperarm01.L", "upperarm02.L"), ("upperleg01.R", "upperleg02.R")):
        assert segment[first] == segment[second]
    assert len({segment[name] for name in ("upperarm01.L", "lowerarm01.L", "wrist.L", "upperarm01.R")}) == 4
