# SPDX-License-Identifier: GPL-3.0-or-later
"""Baking to shape keys: one key a frame, with keyed values, that plays anywhere without Sinew (ALGORITHM 11).

A key holds basis + correction, so it goes where the live correction goes, before the Armature modifier, and adds to the
mesh's own keys as the live correction does.
"""

import re
from collections.abc import Iterator

import bpy
import numpy as np

from .. import mesh_io, session
from ..errors import SinewError
from . import baked_keys

_UNFINISHED = "sinew baking "


class Bake:
    """A bake of some skins over a range of frames. Run through `steps`, or `cancel`led: then nothing has changed."""

    def __init__(self, skins: list, scene, frame_start: int, frame_end: int, step: int, prefix: str):
        _check(skins, frame_start, frame_end, step, prefix)
        self.skins = [skin.name for skin in skins]
        self.scene, self.prefix = scene, prefix
        self.frames = range(frame_start, frame_end + 1, step)
        self.all_frames = range(frame_start, frame_end + 1)
        self.error_mm = 0.0
        self.error_between_mm = 0.0
        self.silenced = 0
        self._frame_before = (scene.frame_current, scene.frame_subframe)
        self._live_before = {skin.name: skin.sinew.live for skin in skins}
        self._had_keys = {skin.name: skin.data.shape_keys is not None for skin in skins}
        self._active_before = {skin.name: skin.active_shape_key_index for skin in skins}
        self.is_baked = False

    def steps(self) -> Iterator[float]:
        """Bakes, a frame at a step, yielding the part done, 0..1. Raises SinewError where a skin can't be evaluated."""
        total = len(self.frames) + len(self.all_frames)
        for skin in self._skins():
            skin.sinew.live = True
        for done, frame in enumerate(self.frames, 1):
            self.scene.frame_set(frame)
            bpy.context.view_layer.update()
            for skin in self._skins():
                self._add_key(skin, frame)
            yield done / total
        for skin in self._skins():
            self._finish(skin)
        self.is_baked = True
        for done, frame in enumerate(self.all_frames, len(self.frames) + 1):
            self._compare(frame)
            yield done / total
        for skin in self._skins():
            skin.sinew.bake_error_mm = self.error_mm
        self._restore_frame()

    def cancel(self):
        """Puts everything back as it was before the bake; one that is only being compared any more is kept."""
        if self.is_baked:
            for skin in self._skins():
                skin.sinew.live = False
            self._restore_frame()
            return
        for skin in self._skins():
            keys = skin.data.shape_keys
            for key in list(keys.key_blocks) if keys else ():
                if key.name.startswith(_UNFINISHED):
                    skin.shape_key_remove(key)
            baked_keys.remove_basis_of_ours(skin, self._had_keys[skin.name])
            skin.sinew.live = self._live_before[skin.name]
            skin.active_shape_key_index = self._active_before[skin.name]
        self._restore_frame()

    def _skins(self) -> list:
        return [bpy.data.objects[name] for name in self.skins]

    def _restore_frame(self):
        frame, subframe = self._frame_before
        self.scene.frame_set(frame, subframe=subframe)

    def _add_key(self, skin, frame: int):
        problem = session.reason(skin)
        state = session.kept_skin(skin)
        if problem or state is None:
            raise SinewError(problem or f"{skin.name} is not part of this scene and view layer: make it visible")
        baked_keys.add_key(skin, f"{_UNFINISHED}{frame}", state.points + state.correction)

    def _finish(self, skin):
        """Swaps the new keys in for those of an earlier bake with this prefix and keys their values."""
        for baked in [baked.name for baked in skin.sinew.baked_keys if _has_prefix(baked.name, self.prefix)]:
            baked_keys.remove_key(skin, baked)
        skin.sinew.bake_error_mm = -1.0  # not compared yet
        keys = skin.data.shape_keys
        self._silence_others(skin)
        # a step before, at and after its frame: the keys cross-fade, and each is alone at its own frame
        for frame in self.frames:
            key = keys.key_blocks[f"{_UNFINISHED}{frame}"]
            key.name = key_name(self.prefix, frame)
            skin.sinew.baked_keys.add().name = key.name
            for at, value in ((-self.frames.step, 0.0), (0, 1.0), (self.frames.step, 0.0)):
                key.value = value
                key.keyframe_insert("value", frame=frame + at)
        paths = {baked_keys.value_path(baked.name) for baked in skin.sinew.baked_keys}
        for curve in baked_keys.curves_of(keys):
            if curve.data_path in paths:
                for point in curve.keyframe_points:
                    point.interpolation = "LINEAR"
        skin.active_shape_key_index = self._active_before[skin.name]

    def _silence_others(self, skin):
        """Mutes correctives, and keys of bakes with another prefix that act at the frames of this one: both would add up."""
        for baked in skin.sinew.baked_keys:
            if baked.joints and not baked.silenced:
                baked.silenced = True
                self.silenced += 1
        curves = {curve.data_path: curve for curve in baked_keys.curves_of(skin.data.shape_keys)}
        for baked in skin.sinew.baked_keys:
            curve = curves.get(baked_keys.value_path(baked.name))
            if curve is None or baked.silenced:
                continue
            first, last = curve.range()  # where the key's value is 0 again
            if first < self.frames[-1] and last > self.frames[0]:
                baked.silenced = True
                self.silenced += 1

    def _compare(self, frame: int):
        """The largest distance between the live skin and the baked one in a frame, both as Blender evaluates them."""
        self.scene.frame_set(frame)
        live = self._points_with(live=True)
        baked = self._points_with(live=False)
        for skin, a, b in zip(self._skins(), live, baked, strict=True):
            if len(a):
                world = np.array(skin.matrix_world.to_3x3(), np.float64)
                distance_mm = 1000.0 * float(np.linalg.norm((a - b) @ world.T, axis=1).max())
                if frame in self.frames:
                    self.error_mm = max(self.error_mm, distance_mm)
                else:
                    self.error_between_mm = max(self.error_between_mm, distance_mm)

    def _points_with(self, live: bool) -> list[np.ndarray]:
        for skin in self._skins():
            skin.sinew.live = live
        depsgraph = bpy.context.evaluated_depsgraph_get()
        depsgraph.update()
        return [mesh_io.read_evaluated_points(skin.evaluated_get(depsgraph).data) for skin in self._skins()]


def key_name(prefix: str, frame: int) -> str:
    """The name of a frame's key."""
    return f"{prefix}{frame:04d}"


def _has_prefix(name: str, prefix: str) -> bool:
    """Whether a bake with this prefix made the key: "walk0001" is none of "wa"."""
    return re.fullmatch(re.escape(prefix) + r"-?\d{3,}", name) is not None


def _check(skins: list, frame_start: int, frame_end: int, step: int, prefix: str):
    if frame_end < frame_start:
        raise SinewError(f"The last frame ({frame_end}) lies before the first ({frame_start})")
    if step < 1:
        raise SinewError(f"Step is {step}: bake every frame (1), every second (2) or fewer")
    baked_keys.check_bakeable(skins, prefix)
    for skin in skins:
        baked_keys.refuse_foreign(skin, (key_name(prefix, frame) for frame in range(frame_start, frame_end + 1, step)))
