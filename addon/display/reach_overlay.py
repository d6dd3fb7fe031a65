# SPDX-License-Identifier: GPL-3.0-or-later
"""The end of the bone and the goal of a reach, drawn over the viewports while the tool runs."""

import bpy
import gpu
from gpu_extras.batch import batch_for_shader

END_COLOUR, GOAL_COLOUR = (0.2, 0.8, 1.0, 1.0), (1.0, 0.6, 0.1, 1.0)
POINT_PX, LINE_PX = 11.0, 2.0

_drawing = None
_end = _goal = None


def show(end, goal):
    """Shows both points, in world space, until `hide`. Without a window nothing is drawn."""
    global _drawing, _end, _goal
    _end, _goal = tuple(end), tuple(goal)
    if _drawing is None and not bpy.app.background:
        _drawing = bpy.types.SpaceView3D.draw_handler_add(_draw, (), "WINDOW", "POST_VIEW")


def hide():
    """Removes the drawing."""
    global _drawing, _end, _goal
    _end = _goal = None
    if _drawing is not None:
        bpy.types.SpaceView3D.draw_handler_remove(_drawing, "WINDOW")
        _drawing = None


def points() -> tuple | None:
    """(end, goal), or None while no reach is shown."""
    return None if _end is None else (_end, _goal)


def _draw():
    line = gpu.shader.from_builtin("POLYLINE_UNIFORM_COLOR")
    _left, _bottom, width, height = gpu.state.viewport_get()
    line.bind()
    line.uniform_float("viewportSize", (width, height))
    line.uniform_float("lineWidth", LINE_PX)
    line.uniform_float("color", GOAL_COLOUR)
    gpu.state.blend_set("ALPHA")
    batch_for_shader(line, "LINES", {"pos": (_end, _goal)}).draw(line)
    point = gpu.shader.from_builtin("POINT_UNIFORM_COLOR")
    gpu.state.point_size_set(POINT_PX)
    for position, colour in ((_goal, GOAL_COLOUR), (_end, END_COLOUR)):
        point.bind()
        point.uniform_float("color", colour)
        batch_for_shader(point, "POINTS", {"pos": (position,)}).draw(point)
    gpu.state.point_size_set(1.0)
    gpu.state.blend_set("NONE")
