# SPDX-License-Identifier: GPL-3.0-or-later
"""Visiting other frames of a scene and returning to the frame that the user had, and the times of frames."""

import math
from collections.abc import Callable, Iterator
from contextlib import contextmanager

import bpy

from . import level_of_detail

FIRST_FRAME, LAST_FRAME = -1_048_574, 1_048_574  # the range of frames in Blender


def time_per_frame(scene) -> float:
    """The time at which Blender evaluates keys, drivers and modifiers, divided by the frame: 1 without Time Remapping."""
    return scene.render.frame_map_old / scene.render.frame_map_new


def split_frame(frame: float) -> tuple[int, float]:
    """The whole frame and the subframe of a frame."""
    whole = math.floor(frame)
    return whole, frame - whole


@contextmanager
def visit_frames(scene) -> Iterator[Callable[[float], None]]:
    """Restores the scene's current frame when the block ends, also by an error. Until then skins have full detail.

    Yields a function that makes a frame current and updates the active view layer. A fraction is a subframe.
    """
    before = scene.frame_current, scene.frame_subframe
    is_visited = False

    def go_to(frame: float):
        nonlocal is_visited
        is_visited = True
        whole, fraction = split_frame(frame)
        scene.frame_set(whole, subframe=fraction)
        bpy.context.view_layer.update()

    try:
        with level_of_detail.full_detail():
            yield go_to
    finally:
        # Setting a frame drops poses that are not keyed, so it is only done where frames were visited.
        if is_visited or (scene.frame_current, scene.frame_subframe) != before:
            frame, subframe = before
            scene.frame_set(frame, subframe=subframe)
