# SPDX-License-Identifier: GPL-3.0-or-later
"""The end of the bone and the goal of a reach, drawn over the viewports while the tool runs."""

import bpy
import gpu
from gpu_extras.batch import batch_for_shader

END_COLOUR, GOAL_COLOUR = (0.2, 0.8, 1.0, 1.0), (1.0, 0.6, 0.1, 1.0)
POINT_PX, LINE_PX = 11.0, 2.0

_drawing = None
# (name of the armature, name of the bone, whether its tail moves, goal in world space)
_shown: tuple | None = None


def show(rig_name: str, bone: str, at_tail: bool, goal):
    """Shows the end of a bone and its goal, a point in world space, until `hide`. Without a window nothing is drawn."""
    global _drawing, _shown
    _shown = rig_name, bone, at_tail, tuple(goal)
    if _drawing is None and not bpy.app.background:
        _drawing = bpy.types.SpaceView3D.draw_handler_add(_draw, (), "WINDOW", "POST_VIEW")


def hide():
    """Removes the drawing."""
    global _drawing, _shown
    _shown = None
    if _drawing is not None:
        bpy.types.SpaceView3D.draw_handler_remove(_drawing, "WINDOW")
        _drawing = None


def points() -> tuple | None:
    """(end of the bone in its current pose, goal), in world space. None while no reach is shown or the bone is gone."""
    if _shown is None:
        return None
    rig_name, bone, at_tail, goal = _shown
    rig = bpy.context.view_layer.objects.get(rig_name)
    found = rig.pose.bones.get(bone) if rig and rig.pose else None
    if found is None:
        return None
    return tuple(rig.matrix_world @ (found.tail if at_tail else found.head)), goal


def _draw():
    found = points()
    if found is None:
        return
    end, goal = found
    line = gpu.shader.from_builtin("POLYLINE_UNIFORM_COLOR")
    _left, _bottom, width, height = gpu.state.viewport_get()
    line.bind()
    line.uniform_float("viewportSize", (width, height))
    line.uniform_float("lineWidth", LINE_PX)
    line.uniform_float("color", GOAL_COLOUR)
    gpu.state.blend_set("ALPHA")
    batch_for_shader(line, "LINES", {"pos": (end, goal)}).draw(line)
    point = gpu.shader.from_builtin("POINT_UNIFORM_COLOR")
    gpu.state.point_size_set(POINT_PX)
    for position, colour in ((goal, GOAL_COLOUR), (end, END_COLOUR)):
        point.bind()
        point.uniform_float("color", colour)
        batch_for_shader(point, "POINTS", {"pos": (position,)}).draw(point)
    gpu.state.point_size_set(1.0)
    gpu.state.blend_set("NONE")
