# SPDX-License-Identifier: GPL-3.0-or-later
"""Playing a point cache on the mesh that it was baked from, by Blender's own Mesh Cache modifier, and the axes of its file."""

from pathlib import Path

import bpy
import numpy as np

from ...scene import live_switch
from .point_cache import Timing

UP_AXES = ("Z", "Y")
_PLAYED_AXES = {"Z": ("POS_Y", "POS_Z"), "Y": ("POS_Z", "NEG_Y")}  # forward and up of the modifier that turn points back


def turned(points: np.ndarray, up_axis: str) -> np.ndarray:
    """(vertices, 3): points as a file has them in which this axis is up."""
    return points if up_axis == "Z" else np.stack((points[:, 0], points[:, 2], -points[:, 1]), axis=1)


def turned_back(points: np.ndarray, up_axis: str) -> np.ndarray:
    """(vertices, 3) float32: points of such a file as Blender has them."""
    turned = points if up_axis == "Z" else np.stack((points[:, 0], -points[:, 2], points[:, 1]), axis=1)
    return turned.astype(np.float32, copy=False)


def attach(skin, path: Path, file_format: str, timing: Timing, up_axis: str, place: int):
    """Adds the modifier that plays a cache, so that `place` of the skin's modifiers come before it, and switches live off.

    One that was attached before is replaced.
    """
    old = live_switch.cache_modifier_of(skin)
    if old and skin.modifiers.find(old.name) < place:
        place -= 1
    detach(skin)
    modifier = skin.modifiers.new(live_switch.CACHE_MODIFIER, "MESH_CACHE")
    modifier.cache_format = file_format
    modifier.filepath = _as_blender_has_it(path)
    modifier.deform_mode, modifier.interpolation = "OVERWRITE", "LINEAR"
    modifier.time_mode, modifier.play_mode = "FRAME", "SCENE"
    # sample = frame_scale * frame - frame_start
    modifier.frame_scale = 1.0 / timing.frames.step
    modifier.frame_start = timing.frames.start / timing.frames.step
    modifier.forward_axis, modifier.up_axis = _PLAYED_AXES[up_axis]
    modifier.show_expanded = False
    skin.modifiers.move(skin.modifiers.find(modifier.name), place)
    skin.sinew.skin.cache_modifier = modifier.persistent_uid
    skin.sinew.skin.live = False


def detach(skin):
    """Takes the modifier away that plays a cache; the file stays where the person wanted it."""
    modifier = live_switch.cache_modifier_of(skin)
    if modifier:
        skin.modifiers.remove(modifier)
    skin.sinew.skin.cache_modifier = 0


def _as_blender_has_it(path: Path) -> str:
    """Relative to the file, where that was saved and lies on the same drive."""
    if not bpy.data.filepath:
        return str(path)
    try:
        return bpy.path.relpath(str(path))
    except ValueError:
        return str(path)
