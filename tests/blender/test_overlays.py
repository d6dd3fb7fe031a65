# SPDX-License-Identifier: GPL-3.0-or-later
"""What Sinew draws over the viewports: the goal of a reach. It is shown while the tool runs, and removed with it."""

from types import SimpleNamespace

import bpy
from bl_ext.user_default.sinew.display import reach_overlay
from bl_ext.user_default.sinew.operators.reach import SINEW_OT_reach
from conftest import bend, select
from mathutils import Vector


def test_the_goal_of_a_reach_is_shown_until_it_ends(arm):
    _skin, rig = arm
    select(rig)
    bpy.ops.object.mode_set(mode="POSE")
    texts = []
    context = SimpleNamespace(workspace=SimpleNamespace(status_text_set=texts.append))
    drag = SimpleNamespace(length=2)
    tool = SimpleNamespace(
        keep_orientation=False, _drag=drag, _rig_name=rig.name, bone="lower", end="TAIL", _goal=Vector((1, 2, 3))
    )
    SINEW_OT_reach._show_help(tool, context)
    bend(rig, 0.7)  # the end is that of the pose that is drawn
    end, goal = reach_overlay.points()
    assert (Vector(end) - rig.pose.bones["lower"].tail).length < 1e-5 and goal == (1, 2, 3)
    assert Vector(end).x < 0.59
    assert SINEW_OT_reach._end(tool, context, {"FINISHED"}) == {"FINISHED"}
    assert reach_overlay.points() is None and texts[-1] is None
