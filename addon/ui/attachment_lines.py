# SPDX-License-Identifier: GPL-3.0-or-later
"""Attachment lines: tendons and curved muscle paths, drawn over viewports whose overlays are on."""

import bpy
import gpu
import numpy as np
from gpu_extras.batch import batch_for_shader

from ..live import attachments, session
from ..scene import characters

COLOUR = (1.0, 0.85, 0.55, 0.9)
WIDTH_PX = 2.0

_drawing = None


def _draw():
    space = bpy.context.space_data
    if not space.overlay.show_overlays:
        return
    for character in characters.in_file():
        rig = character.rig.find()
        state = session.cached_rig(rig) if rig else None
        if state is None or state.musculature is None or not rig.sinew.rig.show_attachments:
            continue
        if bpy.context.view_layer.objects.get(rig.name) != rig:
            continue  # excluded from the view layer (a hidden armature still shows its muscles)
        lines = attachments.lines_of(rig, state)
        if len(lines):
            _draw_lines(lines, rig.matrix_world)


def _draw_lines(lines: np.ndarray, to_world):
    shader = gpu.shader.from_builtin("POLYLINE_UNIFORM_COLOR")
    batch = batch_for_shader(shader, "LINES", {"pos": lines})
    _left, _bottom, width, height = gpu.state.viewport_get()
    shader.bind()
    shader.uniform_float("viewportSize", (width, height))
    shader.uniform_float("lineWidth", WIDTH_PX)
    shader.uniform_float("color", COLOUR)
    gpu.state.blend_set("ALPHA")
    with gpu.matrix.push_pop():
        gpu.matrix.multiply_matrix(to_world)
        batch.draw(shader)
    gpu.state.blend_set("NONE")


def register():
    global _drawing
    if not bpy.app.background:
        _drawing = bpy.types.SpaceView3D.draw_handler_add(_draw, (), "WINDOW", "POST_VIEW")


def unregister():
    global _drawing
    if _drawing:
        bpy.types.SpaceView3D.draw_handler_remove(_drawing, "WINDOW")
    _drawing = None
    attachments.forget()
