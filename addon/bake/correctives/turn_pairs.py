# SPDX-License-Identifier: GPL-3.0-or-later
"""Samples two joint turns together and finds the keys that they need in addition to the keys of each.

The selection is described in docs/mathematics/baking.md, Combinations.
"""

import math
from collections.abc import Iterator
from itertools import combinations

import _sinew
import numpy as np

from ..scratch.joint_turns import JointTurn
from ..scratch.pose_sampler import PoseSampler
from .corrective_settings import Settings
from .skin_keys import JointResult, SkinKeys

# samples on each axis of a quadrant; every second one may get a key
GRID = 6
# Two turns go together to this fraction of their ranges: at both ends, limbs would be inside each other.
FRACTION_TOGETHER = 2.0 / 3.0
# the largest swing of one bone by two turns, as the squared sine of half the angle
FARTHEST_SWING = 0.9


class TurnPairs:
    """Adds the combined keys of pairs of turns to the SkinKeys of all meshes, which must have the keys of single turns."""

    def __init__(self, sampler: PoseSampler, skins: list[SkinKeys], settings: Settings):
        self._sampler, self._skins, self._settings = sampler, skins, settings

    def pairs(self, rig, turns: list[JointTurn]) -> list[tuple[JointTurn, JointTurn]]:
        """Returns the pairs that may need combined keys."""
        joints = {turn.bone for turn in turns}
        return [pair for pair in combinations(turns, 2) if self._may_need_keys(rig, joints, *pair)]

    def sample(self, first: JointTurn, second: JointTurn) -> Iterator[float]:
        """Samples two turns in each quadrant around the rest pose and adds their keys. Yields the fraction done."""
        quadrants = [(a, b) for a in (first.low, first.high) for b in (second.low, second.high) if a and b]
        for done, ends in enumerate(quadrants):
            first_end, second_end = _ends_together(first, ends[0], second, ends[1])
            if any(self._misses(first, part * first_end, second, part * second_end) for part in (1.0, 0.5)):
                first_angles, second_angles = (
                    np.sort(end * np.arange(1, GRID + 1) / GRID) for end in (first_end, second_end)
                )
                poses, samples = self._empty(GRID, GRID)
                for row, first_angle in enumerate(first_angles):
                    for column, second_angle in enumerate(second_angles):
                        self._sample(poses, samples, (row, column), (first, first_angle), (second, second_angle))
                    yield (done + (row + 1) / GRID) / len(quadrants)
                found = self._combined(
                    first, second, first_angles, second_angles, poses, samples, self._settings.max_keys_per_pair
                )
                for skin, keys in zip(self._skins, found, strict=True):
                    _add(skin, first, second, keys)
            yield (done + 1) / len(quadrants)

    def _may_need_keys(self, rig, joints: set[str], first: JointTurn, second: JointTurn) -> bool:
        """Whether two turns are swings of one joint or of two neighbouring ones and move a common vertex."""
        if not self._settings.max_keys_per_pair or first.is_twist or second.is_twist:
            return False
        bones = rig.data.bones
        above = [
            next((bone.name for bone in bones[turn.bone].parent_recursive if bone.name in joints), "")
            for turn in (first, second)
        ]
        if first.bone != second.bone and above[0] != second.bone and above[1] != first.bone:
            return False
        return any((skin.regions[first] & skin.regions[second]).any() for skin in self._skins)

    def _misses(self, first: JointTurn, first_angle: float, second: JointTurn, second_angle: float) -> bool:
        """Whether the keys of the single turns exceed the tolerance with both turns at these angles."""
        poses, samples = self._empty(1, 1)
        self._sample(poses, samples, (0, 0), (first, first_angle), (second, second_angle))
        found = self._combined(first, second, np.array([first_angle]), np.array([second_angle]), poses, samples, 0)
        return any(
            skin.mm_per_metre * keys.error_before > self._settings.tolerance_mm
            for skin, keys in zip(self._skins, found, strict=True)
        )

    def _empty(self, *counts: int) -> tuple[np.ndarray, list[np.ndarray]]:
        """Arrays for the poses of samples, and for the corrections of each mesh in them."""
        vertices = [len(self._sampler.points(skin.index)) for skin in self._skins]
        poses = np.empty((*counts, *self._sampler.pose.shape), np.float32)
        return poses, [np.empty((*counts, count, 3), np.float32) for count in vertices]

    def _sample(self, poses: np.ndarray, samples: list[np.ndarray], cell: tuple[int, int], *angles: tuple[JointTurn, float]):
        for of_skin, correction in zip(samples, self._sampler.corrections(list(angles)), strict=True):
            of_skin[cell] = correction
        poses[cell] = self._sampler.pose

    def _combined(
        self,
        first: JointTurn,
        second: JointTurn,
        first_angles: np.ndarray,
        second_angles: np.ndarray,
        poses: np.ndarray,
        samples: list[np.ndarray],
        most: int,
    ) -> list["_sinew.CombinationKeys"]:
        """Finds the combined keys of each mesh, `most` at most."""
        return [
            _sinew.CombinationKeys(
                self._sampler.skin(skin.index),
                skin.single[first],
                skin.single[second],
                first_angles,
                second_angles,
                poses,
                of_skin,
                *self._settings.mesh_lengths(skin.mm_per_metre),
                most,
            )
            for skin, of_skin in zip(self._skins, samples, strict=True)
        ]


def _add(skin: SkinKeys, first: JointTurn, second: JointTurn, keys: "_sinew.CombinationKeys"):
    errors_mm = (skin.mm_per_metre * error for error in (keys.error_at, keys.error_between, keys.error_before))
    skin.results.append(JointResult([first, second], len(keys), *errors_mm))
    if len(keys):
        skin.pairs.append((first, second, keys))


def _ends_together(first: JointTurn, first_end: float, second: JointTurn, second_end: float) -> tuple[float, float]:
    """Returns the largest angles of two turns together. Two swings of one bone add up to less than half a rotation."""
    fraction = FRACTION_TOGETHER
    while (
        first.bone == second.bone
        and sum(math.sin(0.5 * fraction * end) ** 2 for end in (first_end, second_end)) > FARTHEST_SWING
    ):
        fraction *= 0.9
    return fraction * first_end, fraction * second_end
