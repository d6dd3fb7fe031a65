# SPDX-License-Identifier: GPL-3.0-or-later
"""Plays a point cache on its mesh with Blender's Mesh Cache modifier, and converts points to the axes of its file."""

from pathlib import Path

import bpy
import numpy as np

from ...scene import live_switch
from .point_cache import Timing

UP_AXES = ("Z", "Y")
# the modifier's forward and up axes that undo `to_up_axis`
_PLAYED_AXES = {"Z": ("POS_Y", "POS_Z"), "Y": ("POS_Z", "NEG_Y")}


def to_up_axis(points: np.ndarray, up_axis: str) -> np.ndarray:
    """Rotates (vertices, 3) points from Blender's axes to those of a file with this up axis."""
    return points if up_axis == "Z" else np.stack((points[:, 0], points[:, 2], -points[:, 1]), axis=1)


def from_up_axis(points: np.ndarray, up_axis: str) -> np.ndarray:
    """Rotates (vertices, 3) points of a file with this up axis to Blender's axes; float32."""
    rotated = points if up_axis == "Z" else np.stack((points[:, 0], -points[:, 2], points[:, 1]), axis=1)
    return rotated.astype(np.float32, copy=False)


def attach(skin, path: Path, file_format: str, timing: Timing, up_axis: str, index: int, time_per_frame: float):
    """Adds the modifier that plays a cache at an index of the skin's modifiers, and switches Live off.

    Replaces an earlier such modifier. time_per_frame: as from `current_frame.time_per_frame`.
    """
    old = live_switch.cache_modifier_of(skin)
    if old and skin.modifiers.find(old.name) < index:
        index -= 1
    detach(skin)
    modifier = skin.modifiers.new(live_switch.CACHE_MODIFIER, "MESH_CACHE")
    modifier.cache_format = file_format
    modifier.filepath = _blender_path(path)
    modifier.deform_mode, modifier.interpolation = "OVERWRITE", "LINEAR"
    modifier.time_mode, modifier.play_mode = "FRAME", "SCENE"
    # sample = frame_scale * time - frame_start
    modifier.frame_scale = 1.0 / (timing.frames.step * time_per_frame)
    modifier.frame_start = timing.frames.start / timing.frames.step
    modifier.forward_axis, modifier.up_axis = _PLAYED_AXES[up_axis]
    modifier.show_expanded = False
    skin.modifiers.move(skin.modifiers.find(modifier.name), index)
    skin.sinew.skin.cache_modifier = modifier.persistent_uid
    skin.sinew.skin.live = False


def detach(skin):
    """Removes the modifier that plays a cache; the file stays."""
    modifier = live_switch.cache_modifier_of(skin)
    if modifier:
        skin.modifiers.remove(modifier)
    skin.sinew.skin.cache_modifier = 0


def _blender_path(path: Path) -> str:
    """The path relative to the .blend file, if that was saved on the same drive; else the absolute path."""
    if not bpy.data.filepath:
        return str(path)
    try:
        return bpy.path.relpath(str(path))
    except ValueError:
        return str(path)
