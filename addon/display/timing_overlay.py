# SPDX-License-Identifier: GPL-3.0-or-later
"""The times of a frame, drawn over the viewport as in the thesis (Arabaci 2001). While off, there is no draw handler."""

import bpy
import blf

from . import frame_times

COLOUR = (1.0, 1.0, 1.0, 0.9)
SIZE, LINE, MARGIN = 12, 17, 20
PARTS = (("pose", "Pose"), ("muscles", "Muscles"), ("skin", "Skin"), ("total", "Total"))

_drawing = None


def is_shown() -> bool:
    return frame_times.is_on()


def show(shown: bool):
    """Turns the overlay and the measuring on or off."""
    global _drawing
    frame_times.switch(shown)
    if shown and _drawing is None and not bpy.app.background:
        _drawing = bpy.types.SpaceView3D.draw_handler_add(_draw, (), "WINDOW", "POST_PIXEL")
    elif not shown and _drawing is not None:
        bpy.types.SpaceView3D.draw_handler_remove(_drawing, "WINDOW")
        _drawing = None


def lines() -> list[str]:
    """The lines of the overlay, from top to bottom."""
    means = frame_times.means_ms()
    if not means:
        return ["Sinew: no frame measured yet"]
    times = [f"{name}: {means[part]:.2f} ms" for part, name in PARTS if part in means]
    rate = frame_times.frames_per_second()
    evaluations = frame_times.evaluations()
    return [*times, *([evaluations] if evaluations else []), *([f"{rate:.1f} fps"] if rate else [])]


def _draw():
    if not bpy.context.space_data.overlay.show_overlays:
        return
    scale = bpy.context.preferences.system.ui_scale
    blf.size(0, SIZE * scale)
    blf.color(0, *COLOUR)
    # at the bottom left Blender shows Adjust Last Operation (F9)
    right = bpy.context.region.width - MARGIN * scale - _width_of_sidebar()
    for number, line in enumerate(reversed(lines())):
        width, _height = blf.dimensions(0, line)
        blf.position(0, right - width, (MARGIN + LINE * number) * scale, 0.0)
        blf.draw(0, line)


def _width_of_sidebar() -> int:
    """The width of the sidebar in pixels where it covers the viewport, and 0 where it is closed or beside it."""
    if not bpy.context.preferences.system.use_region_overlap:
        return 0
    return sum(region.width for region in bpy.context.area.regions if region.type == "UI" and region.width > 1)


def unregister():
    show(False)
