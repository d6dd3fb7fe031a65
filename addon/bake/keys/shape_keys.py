# SPDX-License-Identifier: GPL-3.0-or-later
"""Baking frames to shape keys with keyed values, that play anywhere without Sinew (ALGORITHM 11).

A key holds basis + correction, so it goes where the live correction goes, before the Armature modifier, and adds to the
mesh's own keys as the live correction does. Of the frames only those become keys that a tolerance asks for: between two of them
both cross-fade, and the frames and half frames that lie there are checked (`_sinew.KeptSamples`).

Why frames and not shapes of their own: for the demo's motion over 250 frames (13,380 vertices) a tolerance of 0.1, 0.25, 0.5, 1
and 2 mm takes 64, 37, 25, 17 and 11 frames, without shapes that are shown twice; shapes at such frames fitted by least squares
63, 34, 23, 15, 11; a basis of the least rank (singular vectors, each keyed in every frame) 36, 20, 14, 11, 8.
The basis would halve the keys, but none of its shapes is one that a person could look at or edit, and each needs a keyframe
in every frame.
"""

import math
import re
from collections.abc import Iterator

import bpy
import _sinew
import numpy as np

from ...errors import SinewError
from ...live import session
from ...scene import armature_modifier, mesh_arrays
from . import key_store, value_curves

# of the work, as far as the progress bar shows it
_SAMPLED, _WRITTEN = 0.8, 0.85
# what float32 can tell on a body
LEAST_MM = 1e-4
# frames in which Blender's evaluation of the keys is held against the live skin
COMPARED = 24


class Bake:
    """A bake of some skins over a range of frames. Run through `steps`, or `cancel`led: then nothing has changed.

    tolerance_mm: how far the baked skin may be from the live one at any frame or half frame, in the world. 0: every frame is a
    key but those that others give exactly.
    """

    def __init__(self, skins: list, scene, frame_start: int, frame_end: int, step: int, prefix: str, tolerance_mm: float):
        _check(skins, frame_start, frame_end, step, prefix)
        self.skins = [skin.name for skin in skins]
        self.scene, self.prefix, self.tolerance_mm = scene, prefix, tolerance_mm
        self.frames = range(frame_start, frame_end + 1, step)
        self.error_mm = 0.0
        self.error_between_mm = 0.0
        self.keys = 0
        self.silenced = 0
        # twice the frame, so that half frames are whole numbers
        self._halves = range(2 * frame_start, 2 * frame_end + 1)
        self._samples = {skin.name: _Samples(skin, len(self._halves)) for skin in skins}
        self._frame_before = (scene.frame_current, scene.frame_subframe)
        self._live_before = {skin.name: skin.sinew.live for skin in skins}
        self.is_baked = False

    def steps(self) -> Iterator[float]:
        """Bakes, a pose at a step, yielding the part done, 0..1. Raises SinewError where a skin can't be evaluated."""
        for skin in self._skins():
            skin.sinew.live = True
        for done, half in enumerate(self._halves):
            self._go_to(half)
            for skin in self._skins():
                self._samples[skin.name].read(skin, done, self.tolerance_mm)
            yield _SAMPLED * (done + 1) / len(self._halves)
        for skin in self._skins():
            self._write(skin)
        self._samples.clear()
        self.is_baked = True
        yield _WRITTEN
        step = max(len(self._halves) // COMPARED, 1)
        for half in self._halves[::step]:
            self._compare(half)
            yield _WRITTEN + (1.0 - _WRITTEN) * (half - self._halves[0]) / len(self._halves)
        for skin in self._skins():
            skin.sinew.live = False
            skin.sinew.bake_error_mm = max(self.error_mm, self.error_between_mm)
        self._restore_frame()

    def cancel(self):
        """Puts everything back as it was before the bake; one that is only being compared any more is kept."""
        for skin in self._skins():
            skin.sinew.live = self._live_before[skin.name] and not self.is_baked
        self._restore_frame()

    def _skins(self) -> list:
        found = [bpy.data.objects.get(name) for name in self.skins]
        if None in found:
            raise SinewError("a mesh was renamed or deleted meanwhile: bake again")
        return found

    def _go_to(self, half: int):
        self.scene.frame_set(half // 2, subframe=0.5 * (half % 2))
        bpy.context.view_layer.update()

    def _restore_frame(self):
        frame, subframe = self._frame_before
        self.scene.frame_set(frame, subframe=subframe)

    def _write(self, skin):
        """Swaps the keys that are needed in for those of an earlier bake with this prefix, and keys their values."""
        samples = self._samples[skin.name]
        kept = self._kept(samples)
        errors_mm = kept.errors * samples.per_metre
        at_frames = np.array([self._is_frame(half) for half in self._halves])
        self.error_mm = max(self.error_mm, float(errors_mm[at_frames].max()))
        self.error_between_mm = max(self.error_between_mm, float(errors_mm[~at_frames].max(initial=0.0)))
        active = skin.active_shape_key_index
        for baked in [baked.name for baked in skin.sinew.baked_keys if _has_prefix(baked.name, self.prefix)]:
            key_store.remove_key(skin, baked)
        self._silence_others(skin)
        points = mesh_arrays.read_points(skin.data)
        shown = [(0.5 * self._halves[place], sample) for place, sample in zip(kept.places, kept.shown, strict=True)]
        for sample in sorted({sample for _, sample in shown if sample is not None}):
            name = key_name(self.prefix, 0.5 * self._halves[sample])
            key = key_store.add_key(skin, name, points + samples.corrections[sample])
            value_curves.key_values(skin.data.shape_keys, key, self._fade(shown, sample))
            skin.sinew.baked_keys.add().name = name
            self.keys += 1
        skin.active_shape_key_index = active

    def _kept(self, samples: "_Samples") -> "_sinew.KeptSamples":
        """Which frames are kept, and half frames where two frames in a row are too far from what lies between."""
        candidates = np.array([self._is_frame(half) for half in self._halves])
        kept = samples.kept(candidates)
        if self.frames.step == 1 and self.tolerance_mm > 0.0:
            missed = kept.errors * samples.per_metre > self.tolerance_mm
            if missed.any():
                kept = samples.kept(candidates | missed)
        return kept

    def _is_frame(self, half: int) -> bool:
        """Whether this is one of the frames asked for."""
        return half % 2 == 0 and half // 2 in self.frames

    def _fade(self, shown: list[tuple[float, int | None]], sample: int) -> list[tuple[float, float]]:
        """(frame, value) of a key: 1 where it is shown, 0 where another is, and before and after the range."""
        first, last, step = self.frames[0], self.frames[-1], self.frames.step
        whole = dict([(first, shown[0][1]), *shown, (last, shown[-1][1])])
        values = [(frame, float(whole[frame] == sample)) for frame in sorted(whole)]
        return [(first - step, 0.0), *values, (last + step, 0.0)]

    def _silence_others(self, skin):
        """Mutes correctives, and keys of bakes with another prefix that act at the frames of this one: both would add up."""
        keys = skin.data.shape_keys
        curves = {curve.data_path: curve for curve in key_store.curves_of(keys)} if keys else {}
        for baked in skin.sinew.baked_keys:
            if baked.silenced:
                continue
            if not baked.joints:
                curve = curves.get(key_store.value_path(baked.name))
                if curve is None:
                    continue
                first, last = curve.range()  # where the key's value is 0 again
                if first >= self.frames[-1] or last <= self.frames[0]:
                    continue
            baked.silenced = True
            self.silenced += 1

    def _compare(self, half: int):
        """The largest distance between the live skin and the baked one in a pose, both as Blender evaluates them."""
        self._go_to(half)
        live = self._points_with(live=True)
        baked = self._points_with(live=False)
        for skin, a, b in zip(self._skins(), live, baked, strict=True):
            if len(a):
                world = np.array(skin.matrix_world.to_3x3(), np.float64)
                distance_mm = 1000.0 * float(np.linalg.norm((a - b) @ world.T, axis=1).max())
                if self._is_frame(half):
                    self.error_mm = max(self.error_mm, distance_mm)
                else:
                    self.error_between_mm = max(self.error_between_mm, distance_mm)

    def _points_with(self, live: bool) -> list[np.ndarray]:
        for skin in self._skins():
            skin.sinew.live = live
        depsgraph = bpy.context.evaluated_depsgraph_get()
        depsgraph.update()
        return [mesh_arrays.read_evaluated_points(skin.evaluated_get(depsgraph).data) for skin in self._skins()]


class _Samples:
    """What a skin's correction is at each frame and half frame, and the pose that it belongs to."""

    def __init__(self, skin, count: int):
        self.corrections = np.empty((count, len(skin.data.vertices), 3), np.float32)
        self.per_metre = np.empty(count)  # mm in the world for a metre in the mesh
        self._tolerances = np.empty(count)
        self._poses = None
        self._skin: _sinew.Skin | None = None

    def read(self, skin, place: int, tolerance_mm: float):
        """Keeps what the live skin is now. Raises SinewError where it does not follow its tissues."""
        problem = session.reason(skin)
        state = session.kept_skin(skin)
        if problem or state is None:
            raise SinewError(problem or f"{skin.name} is not part of this scene and view layer: make it visible")
        pose = session.kept_rig(armature_modifier.rig_of(skin)).pose
        if self._poses is None:
            self._poses = np.empty((len(self.corrections), *pose.shape), np.float32)
        self.corrections[place], self._poses[place], self._skin = state.correction, pose, state.skin
        self.per_metre[place] = key_store.mm_per_metre(skin)
        self._tolerances[place] = max(tolerance_mm, LEAST_MM) / self.per_metre[place]

    def kept(self, candidates: np.ndarray) -> "_sinew.KeptSamples":
        at = np.arange(len(candidates), dtype=np.float64)
        return _sinew.KeptSamples(self._skin, self._poses, self.corrections, at, self._tolerances, candidates)


def key_name(prefix: str, frame: float) -> str:
    """The name of a frame's or half frame's key."""
    return f"{prefix}{math.floor(frame):04d}{'.5' if frame % 1 else ''}"


def _has_prefix(name: str, prefix: str) -> bool:
    """Whether a bake with this prefix made the key: "walk0001" is none of "wa"."""
    return re.fullmatch(re.escape(prefix) + r"-?\d{3,}(\.5)?", name) is not None


def _check(skins: list, frame_start: int, frame_end: int, step: int, prefix: str):
    if frame_end < frame_start:
        raise SinewError(f"The last frame ({frame_end}) lies before the first ({frame_start})")
    if step < 1:
        raise SinewError(f"Step is {step}: bake every frame (1), every second (2) or fewer")
    key_store.check_bakeable(skins, prefix)
    for skin in skins:
        key_store.refuse_foreign(skin, (key_name(prefix, frame) for frame in range(frame_start, frame_end + 1, step)))
