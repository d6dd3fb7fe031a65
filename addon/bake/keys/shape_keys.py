# SPDX-License-Identifier: GPL-3.0-or-later
"""Bakes frames to shape keys with animated values, which play without Sinew.

A key holds the basis plus the correction. So it acts before the Armature modifier and adds to the mesh's other keys, as
the live correction does. Only the frames that the tolerance requires become keys. Between two of them both cross-fade,
and the frames and half frames between are checked (docs/mathematics/baking.md, Reduction of frames).

Keys hold the shapes of frames, not fitted shapes or singular vectors, which that page compares. Singular vectors would need
fewer keys, but nobody could edit their shapes.
"""

import math
import re
import tempfile
from collections.abc import Callable, Generator, Iterator

import bpy
import _sinew
import numpy as np

from ...errors import SinewError
from ...live import session
from ...scene import armature_modifier, live_switch, mesh_arrays
from ...scene.current_frame import time_per_frame
from ...scene.lookup import objects_named
from .. import requirements
from ..scratch.character_scene import visit_frames_of_characters
from . import key_store, value_curves

# fractions of the progress bar: sampling ends, writing ends
_SAMPLED, _WRITTEN = 0.8, 0.85
# the precision of float32 at the size of a body
LEAST_MM = 1e-4
# number of frames in which Blender's evaluation of the keys is compared with the live skin
COMPARED = 24


class Bake:
    """A bake of skins over a range of frames. If `steps` are not run to the end, or after `cancel`, nothing has changed.

    tolerance_mm: the largest distance in the world of the baked skin from the live skin, at frames and half frames. 0: each
    frame becomes a key, except those that others show exactly.
    """

    def __init__(self, skins: list, scene, frame_start: int, frame_end: int, step: int, prefix: str, tolerance_mm: float):
        _check(skins, frame_start, frame_end, step, prefix)
        self.skins = [skin.name for skin in skins]
        self.scene, self.prefix, self.tolerance_mm = scene, prefix, tolerance_mm
        self.frames = range(frame_start, frame_end + 1, step)
        self.error_mm = 0.0
        self.error_between_mm = 0.0
        self.keys = 0
        self.muted_keys = 0
        # Doubled frame numbers, so that half frames are integers.
        self._halves = range(2 * frame_start, 2 * frame_end + 1)
        self._samples = {skin.name: _Samples(skin, len(self._halves)) for skin in skins}
        self._time_per_frame = time_per_frame(scene)
        self._live_before = live_switch.switches_of(skins)
        self._running: Generator[float] | None = None
        self.is_baked = False

    def steps(self) -> Iterator[float]:
        """Bakes one pose per step and yields the fraction done, 0..1. Raises SinewError if a skin can't be evaluated."""
        self._running = self._run()
        return self._running

    def cancel(self):
        """Restores the state before the bake. If only the comparison was left, the keys stay."""
        if self._running:
            self._running.close()

    def _run(self) -> Generator[float]:
        with visit_frames_of_characters(self.scene, self._skins()) as evaluate:
            try:
                yield from self._bake(evaluate)
            except BaseException:  # includes the closing of this generator, when the user cancels
                live_switch.restore_switches({uid: live and not self.is_baked for uid, live in self._live_before.items()})
                raise

    def _bake(self, evaluate: Callable[[float], bpy.types.Depsgraph]) -> Iterator[float]:
        for skin in self._skins():
            skin.sinew.skin.live = True
        for index, half in enumerate(self._halves):
            depsgraph = evaluate(0.5 * half)
            for skin in self._skins():
                self._samples[skin.name].read(skin, depsgraph, index, self.tolerance_mm)
            yield _SAMPLED * (index + 1) / len(self._halves)
        for skin in self._skins():
            self._write(skin)
        self._samples.clear()
        self.is_baked = True
        yield _WRITTEN
        step = max(len(self._halves) // COMPARED, 1)
        for half in self._halves[::step]:
            self._compare(half, evaluate(0.5 * half))
            yield _WRITTEN + (1.0 - _WRITTEN) * (half - self._halves[0]) / len(self._halves)
        for skin in self._skins():
            skin.sinew.skin.live = False
            skin.sinew.skin.bake_error_mm = max(self.error_mm, self.error_between_mm)

    def _skins(self) -> list:
        return objects_named(self.skins, "bake again")

    def _write(self, skin):
        """Replaces the keys of an earlier bake with this prefix by the required keys, and animates their values."""
        samples = self._samples[skin.name]
        kept = self._kept(samples)
        errors_mm = kept.errors * samples.mm_per_metre
        at_frames = np.array([self._is_frame(half) for half in self._halves])
        self.error_mm = max(self.error_mm, float(errors_mm[at_frames].max()))
        self.error_between_mm = max(self.error_between_mm, float(errors_mm[~at_frames].max(initial=0.0)))
        active = skin.active_shape_key_index
        for baked in [baked.name for baked in skin.sinew.skin.baked_keys if _has_prefix(baked.name, self.prefix)]:
            key_store.remove_key(skin, baked)
        self._silence_others(skin)
        points = mesh_arrays.read_points(skin.data)
        shown = [(0.5 * self._halves[index], sample) for index, sample in zip(kept.places, kept.shown, strict=True)]
        for sample in sorted({sample for _, sample in shown if sample is not None}):
            name = key_name(self.prefix, 0.5 * self._halves[sample])
            key = key_store.add_key(skin, name, points + samples.corrections[sample])
            value_curves.key_values(skin.data.shape_keys, key, self._fade(shown, sample), self._time_per_frame)
            skin.sinew.skin.baked_keys.add().name = name
            self.keys += 1
        skin.active_shape_key_index = active

    def _kept(self, samples: "_Samples") -> "_sinew.KeptSamples":
        """Selects the frames to keep, and half frames where two consecutive frames are too far from what is between them."""
        candidates = np.array([self._is_frame(half) for half in self._halves])
        kept = samples.kept(candidates)
        if self.frames.step == 1 and self.tolerance_mm > 0.0:
            missed = kept.errors * samples.mm_per_metre > self.tolerance_mm
            if missed.any():
                kept = samples.kept(candidates | missed)
        return kept

    def _is_frame(self, half: int) -> bool:
        """Whether a doubled frame number is one of the frames to bake."""
        return half % 2 == 0 and half // 2 in self.frames

    def _fade(self, shown: list[tuple[float, int | None]], sample: int) -> list[tuple[float, float]]:
        """Returns (frame, value) of a key: 1 where its sample is shown, 0 at other samples and outside the range."""
        first, last, step = self.frames[0], self.frames[-1], self.frames.step
        whole = dict([(first, shown[0][1]), *shown, (last, shown[-1][1])])
        values = [(frame, float(whole[frame] == sample)) for frame in sorted(whole)]
        return [(first - step, 0.0), *values, (last + step, 0.0)]

    def _silence_others(self, skin):
        """Mutes correctives, and keys with another prefix that act at the same frames: their effects would add up."""
        keys = skin.data.shape_keys
        curves = {curve.data_path: curve for curve in key_store.curves_of(keys)} if keys else {}
        for baked in skin.sinew.skin.baked_keys:
            if baked.muted_by_sinew:
                continue
            if not baked.joints:
                curve = curves.get(key_store.value_path(baked.name))
                if curve is None:
                    continue
                first, last = (time / self._time_per_frame for time in curve.range())  # the key's value is 0 at both ends
                if first >= self.frames[-1] or last <= self.frames[0]:
                    continue
            baked.muted_by_sinew = True
            self.muted_keys += 1

    def _compare(self, half: int, depsgraph):
        """Updates the errors with the distances of the live and the baked skins in this pose, as Blender evaluates both."""
        live = self._points_with(depsgraph, live=True)
        baked = self._points_with(depsgraph, live=False)
        for skin, a, b in zip(self._skins(), live, baked, strict=True):
            if len(a):
                world = np.array(skin.evaluated_get(depsgraph).matrix_world.to_3x3(), np.float64)
                distance_mm = 1000.0 * float(np.linalg.norm((a - b) @ world.T, axis=1).max())
                if self._is_frame(half):
                    self.error_mm = max(self.error_mm, distance_mm)
                else:
                    self.error_between_mm = max(self.error_between_mm, distance_mm)

    def _points_with(self, depsgraph, live: bool) -> list[np.ndarray]:
        for skin in self._skins():
            skin.sinew.skin.live = live
        depsgraph.view_layer.update()
        return [mesh_arrays.read_evaluated_points(skin.evaluated_get(depsgraph).data) for skin in self._skins()]


class _Samples:
    """The corrections of a skin at all frames and half frames, with the poses that they belong to.

    They are in a temporary file without a name, so that a long bake of a large mesh does not have to fit in memory.
    """

    def __init__(self, skin, count: int):
        shape = count, len(skin.data.vertices), 3
        with tempfile.TemporaryFile(prefix="sinew-bake-") as file:  # the map keeps it open
            file.truncate(4 * math.prod(shape))
            self.corrections = np.memmap(file, np.float32, "r+", shape=shape)
        self.mm_per_metre = np.empty(count)  # see key_store.mm_per_metre
        self._tolerances = np.empty(count)
        self._poses = None
        self._skin: _sinew.Skin | None = None

    def read(self, skin, depsgraph, index: int, tolerance_mm: float):
        """Stores the live skin's state in an evaluation. Raises SinewError if the skin does not follow its tissues."""
        problem = session.reason(skin)
        state = session.cached_skin(skin)
        if problem or state is None:
            raise SinewError(problem or f"{skin.name} is not part of this scene and view layer. Make it visible")
        pose = session.cached_rig(armature_modifier.rig_of(skin)).pose
        if self._poses is None:
            self._poses = np.empty((len(self.corrections), *pose.shape), np.float32)
        self.corrections[index], self._poses[index], self._skin = state.correction, pose, state.skin
        self.mm_per_metre[index] = key_store.mm_per_metre(skin.evaluated_get(depsgraph))
        self._tolerances[index] = max(tolerance_mm, LEAST_MM) / self.mm_per_metre[index]

    def kept(self, candidates: np.ndarray) -> "_sinew.KeptSamples":
        """Selects the samples to keep. candidates: (samples,) bool, those that may be kept."""
        at = np.arange(len(candidates), dtype=np.float64)
        return _sinew.KeptSamples(self._skin, self._poses, self.corrections, at, self._tolerances, candidates)


def key_name(prefix: str, frame: float) -> str:
    """The name of the key of a frame or half frame."""
    return f"{prefix}{math.floor(frame):04d}{'.5' if frame % 1 else ''}"


def _has_prefix(name: str, prefix: str) -> bool:
    """Whether a bake with exactly this prefix made the key: "walk0001" does not have the prefix "wa"."""
    return re.fullmatch(re.escape(prefix) + r"-?\d{3,}(\.5)?", name) is not None


def _check(skins: list, frame_start: int, frame_end: int, step: int, prefix: str):
    requirements.require_frames(frame_start, frame_end)
    if step < 1:
        raise SinewError(f"Step is {step}. Bake every frame (1), every second (2) or fewer")
    key_store.check_bakeable(skins, prefix)
    for skin in skins:
        key_store.refuse_foreign(skin, (key_name(prefix, frame) for frame in range(frame_start, frame_end + 1, step)))
