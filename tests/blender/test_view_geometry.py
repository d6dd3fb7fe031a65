# SPDX-License-Identifier: GPL-3.0-or-later
"""Viewport geometry of the Reach tool, with a stand-in for a viewport that looks down on the xy plane."""

import types

import pytest
from bl_ext.user_default.sinew.operators import view_geometry
from mathutils import Matrix, Quaternion, Vector

pytestmark = pytest.mark.one_blender

SIZE_PX = 200
HALF_WIDTH_M = 1.0


def region(kind, x, width):
    return types.SimpleNamespace(type=kind, x=x, y=0, width=width, height=SIZE_PX)


@pytest.fixture
def context():
    """An orthographic view from above: 100 pixels are one metre, the world's origin is in the middle."""
    view = types.SimpleNamespace(
        perspective_matrix=Matrix.Diagonal((1 / HALF_WIDTH_M, 1 / HALF_WIDTH_M, -1 / 100, 1)),
        view_matrix=Matrix.Translation((0, 0, -10)),
        view_rotation=Quaternion(),
        view_distance=10.0,
        is_perspective=False,
        view_perspective="ORTHO",
    )
    area = types.SimpleNamespace(
        regions=[region("UI", 150, 50), region("WINDOW", 0, SIZE_PX)],
        spaces=types.SimpleNamespace(active=types.SimpleNamespace(region_3d=view)),
    )
    return types.SimpleNamespace(area=area)


def test_the_mouse_is_over_the_scene_or_over_a_sidebar(context):
    at = lambda x, y: types.SimpleNamespace(mouse_x=x, mouse_y=y)  # noqa: E731
    assert view_geometry.is_over_scene(context.area, at(10, 10))
    assert not view_geometry.is_over_scene(context.area, at(160, 10))
    assert not view_geometry.is_over_scene(context.area, at(10, SIZE_PX + 1))


def test_the_bone_with_the_nearest_end_is_picked(context, arm):
    _skin, rig = arm  # upper: 0 to 0.3 m, lower: 0.3 to 0.6 m along x; 100 pixels are the origin
    tail_of_lower, elbow, nowhere = Vector((160, 100)), Vector((130, 100)), Vector((20, 20))
    assert view_geometry.bone_near(context, rig, tail_of_lower, True, "") == "lower"
    assert view_geometry.bone_near(context, rig, elbow, True, "") == "upper"
    assert view_geometry.bone_near(context, rig, elbow, False, "") == "lower"
    assert view_geometry.bone_near(context, rig, nowhere, True, "") is None


def test_hidden_bones_are_not_picked(context, arm):
    _skin, rig = arm
    lower = rig.pose.bones["lower"]
    (lower if hasattr(lower, "hide") else lower.bone).hide = True  # Blender 5 hides the pose bone
    assert view_geometry.bone_near(context, rig, Vector((160, 100)), True, "") == "upper"


def test_the_bone_in_use_wins_a_tie(context, arm):
    _skin, rig = arm
    middle = Vector((145.2, 100))  # 0.4 pixels nearer to the tail of lower
    assert view_geometry.bone_near(context, rig, middle, True, "") == "lower"
    assert view_geometry.bone_near(context, rig, middle, True, "upper") == "upper"


def test_a_click_sets_a_goal_far_in_its_direction(context):
    end = Vector((0.1, 0.0, 2.0))
    assert (view_geometry.under_mouse(context, Vector((110, 150)), end) - Vector((0.1, 0.5, 2.0))).length < 1e-5
    assert (view_geometry.far_goal(context, Vector((110, 150)), end) - Vector((0.1, 5.0, 2.0))).length < 1e-4


def test_a_step_of_depth_leads_away_from_the_viewer(context):
    assert (view_geometry.depth_step(context) - Vector((0, 0, -0.15))).length < 1e-6


def test_goals_on_an_axis_and_on_the_grid():
    assert view_geometry.on_axis(Vector((3, 4, 5)), Vector((1, 1, 1)), "Y") == Vector((1, 4, 1))
    assert (view_geometry.on_grid(Vector((0.12, -0.13, 0.0))) - Vector((0.1, -0.15, 0.0))).length < 1e-6
