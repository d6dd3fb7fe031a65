# SPDX-License-Identifier: GPL-3.0-or-later
"""Samples each joint turn by itself and finds the keys that it needs (docs/mathematics/baking.md, Correctives)."""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise

import _sinew
import numpy as np

from ..scratch.joint_turns import JointTurn
from ..scratch.pose_sampler import PoseSampler
from .corrective_settings import Settings
from .skin_keys import JointResult, SkinKeys

# the distance of samples: at first, and the smallest where the skin needs more
STEP_RAD, FINEST_RAD = math.radians(5.0), math.radians(0.3)
# The tolerance is multiplied by this until the number of keys is within its limit.
LOOSENED = 1.1


@dataclass(frozen=True)
class _Sample:
    """The corrections of all meshes in one pose, and that pose as the core reads it."""

    corrections: list[np.ndarray]
    pose: np.ndarray


class SingleTurns:
    """Adds the keys of single turns to the SkinKeys of all meshes."""

    def __init__(self, sampler: PoseSampler, skins: list[SkinKeys], settings: Settings):
        self._sampler, self._skins, self._settings = sampler, skins, settings

    def sample(self, turn: JointTurn) -> Iterator[float]:
        """Samples a turn, more finely where linear interpolation misses it, and adds its keys. Yields the fraction done."""
        angles = [*_angles_to(turn.low)[::-1], 0.0, *_angles_to(turn.high)]
        samples: dict[float, _Sample] = {}
        for angle in angles:
            samples[angle] = self._sampled(turn, angle)
        for correction in samples[0.0].corrections:
            correction[:] = 0.0  # nothing is corrected in the rest pose
        jumps_mm = [0.0] * len(self._skins)
        for index, (low, high) in enumerate(pairwise(angles)):
            self._refine(turn, samples, low, high, jumps_mm)
            yield (index + 1) / (len(angles) - 1)
        angles = sorted(samples)
        poses = np.array([samples[angle].pose for angle in angles])
        samples_of = {
            skin.name: np.array([samples[angle].corrections[skin.index] for angle in angles]) for skin in self._skins
        }
        for skin, keys in self._keys_of_turn(poses, samples_of, np.array(angles)):
            skin.single[turn] = keys
            region = np.zeros(len(samples_of[skin.name][0]), bool)
            for key in range(len(keys)):
                region |= keys.correction(key).any(axis=1)
            skin.regions[turn] = region
            between_mm = max(skin.mm_per_metre * keys.error_between, jumps_mm[self._skins.index(skin)])
            skin.results.append(JointResult([turn], len(keys), skin.mm_per_metre * keys.error_at, between_mm))

    def _sampled(self, turn: JointTurn, angle: float) -> _Sample:
        return _Sample(self._sampler.corrections([(turn, angle)]), self._sampler.pose.copy())

    def _refine(self, turn: JointTurn, samples: dict[float, _Sample], low: float, high: float, jumps_mm: list[float]):
        """Samples the middle of an interval, and both halves again, while linear interpolation misses the skin."""
        middle = 0.5 * (low + high)
        samples[middle] = self._sampled(turn, middle)
        three = [samples[angle] for angle in (low, middle, high)]
        misses_mm = [self._interpolation_error_mm(skin, three) for skin in self._skins]
        # For a parabola, the middle sample divides the largest error of linear interpolation by 4.
        if max(misses_mm) <= 0.5 * self._settings.tolerance_mm:
            return
        if high - low > 2.0 * FINEST_RAD:
            self._refine(turn, samples, low, middle, jumps_mm)
            self._refine(turn, samples, middle, high, jumps_mm)
        else:
            # The live skin jumps here, for instance at a contact. More samples would not help.
            jumps_mm[:] = map(max, jumps_mm, misses_mm)

    def _interpolation_error_mm(self, skin: SkinKeys, three: list[_Sample]) -> float:
        """The distance, on the posed skin, of the middle one of three samples from the mean of the others."""
        poses = np.array([sample.pose for sample in three])
        corrections = np.array([sample.corrections[skin.index] for sample in three])
        ends, at = np.array([True, False, True]), np.arange(3.0)
        line = _sinew.KeptSamples(self._sampler.skin(skin.index), poses, corrections, at, np.zeros(3), ends)
        return skin.mm_per_metre * float(line.errors[1])

    def _keys_of_turn(self, poses: np.ndarray, samples_of: dict[str, np.ndarray], angles: np.ndarray):
        """The keys of each mesh, as (SkinKeys, MotionKeys). Layers worn over each other have keys at the same angles.

        samples_of: the corrections of each mesh by its name. A mesh that the turn does not correct gets no keys.
        """
        for body in dict.fromkeys(skin.body for skin in self._skins):
            layers = [skin for skin in self._skins if skin.body == body]
            chosen = self._within_limit(layers, poses, samples_of, angles)
            together = sorted({index for keys in chosen for index in keys.indices})
            for skin, keys in zip(layers, chosen, strict=True):
                if len(keys) and keys.indices != together:
                    keys = self._motion_keys(skin, poses, samples_of[skin.name], angles, 1.0, together)
                yield skin, keys

    def _within_limit(
        self, layers: list[SkinKeys], poses: np.ndarray, samples_of: dict[str, np.ndarray], angles: np.ndarray
    ):
        """The keys that the tolerance requires, or as many as are allowed, with a larger tolerance, for each of `layers`."""
        loosened = 1.0
        while True:
            keys = [self._motion_keys(skin, poses, samples_of[skin.name], angles, loosened) for skin in layers]
            count = len({index for of_layer in keys for index in of_layer.indices})
            if count <= (self._settings.max_keys_per_turn or count):
                return keys
            loosened *= LOOSENED

    def _motion_keys(
        self,
        skin: SkinKeys,
        poses: np.ndarray,
        samples: np.ndarray,
        angles: np.ndarray,
        loosened: float,
        indices: list[int] | None = None,
    ) -> "_sinew.MotionKeys":
        tolerance, threshold = self._settings.mesh_lengths(skin.mm_per_metre)
        core = self._sampler.skin(skin.index)
        return _sinew.MotionKeys(core, poses, samples, angles, loosened * tolerance, threshold, indices)


def _angles_to(end: float) -> list[float]:
    """Angles from the rest pose to an end, without 0, with the end."""
    count = math.ceil(abs(end) / STEP_RAD - 1e-6)
    return [end * (step + 1) / count for step in range(count)]
