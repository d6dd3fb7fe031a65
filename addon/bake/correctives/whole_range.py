# SPDX-License-Identifier: GPL-3.0-or-later
"""Measures the keys of a joint over its whole range, with all of its turns at once.

Keys are chosen from single turns and from pairs on a grid of two thirds of each range (`single_turns`, `turn_pairs`). A
joint may go further: to the ellipse whose half axes are the ends of its two swings, and twist there. The largest error found
here is part of the report, so that no pose inside that range has a larger one than stated.
"""

import math
from collections.abc import Iterator
from itertools import product

import _sinew
import numpy as np

from ..scratch.joint_turns import JointTurn, TurnAngles
from ..scratch.pose_sampler import PoseSampler
from .corrective_drivers import TentWeight, tent_at
from .skin_keys import JointResult, SkinKeys

_DIRECTIONS = 16
_RADII, _TWISTED_RADII = (1.0 / 3.0, 2.0 / 3.0, 1.0), (2.0 / 3.0, 1.0)
# around the worst sample: steps of the direction (fractions of a quarter turn), the radius and the twist (fractions)
_FIRST_STEP, _REFINEMENTS = 0.125, 3


class WholeRange:
    """Adds the errors of whole joints to the SkinKeys of all meshes, which must have all of their keys."""

    def __init__(self, sampler: PoseSampler, skins: list[SkinKeys]):
        self._sampler, self._skins = sampler, skins

    def joints(self, turns: list[JointTurn]) -> list[list[JointTurn]]:
        """The turns of each joint that has several."""
        by_bone: dict[str, list[JointTurn]] = {}
        for turn in turns:
            by_bone.setdefault(turn.bone, []).append(turn)
        return [of_bone for of_bone in by_bone.values() if len(of_bone) > 1]

    def measure(self, turns: list[JointTurn]) -> Iterator[float]:
        """Measures the keys of one joint and adds its result. Yields the fraction done. turns: all of the joint."""
        samples = _samples_of(turns)
        errors: dict[tuple[float, float, float], list[tuple[float, float]]] = {}
        for done, sample in enumerate(samples):
            errors[sample] = self._errors(_angles_at(turns, *sample))
            yield 0.8 * (done + 1) / len(samples)
        step = _FIRST_STEP
        for done in range(_REFINEMENTS):
            worst = max(errors, key=lambda sample: max(error for error, _before in errors[sample]))
            for sample in _around(worst, step, turns):
                if sample not in errors:
                    errors[sample] = self._errors(_angles_at(turns, *sample))
            step *= 0.5
            yield 0.8 + 0.2 * (done + 1) / _REFINEMENTS
        for index, skin in enumerate(self._skins):
            error, before = (max(found[index][which] for found in errors.values()) for which in (0, 1))
            skin.results.append(JointResult(turns, 0, 0.0, error, before))

    def _errors(self, angles: TurnAngles) -> list[tuple[float, float]]:
        """The error of each mesh in one pose, mm in the world, with all keys and without the combined ones."""
        live = self._sampler.corrections(angles)
        pose = self._sampler.pose
        return [self._error(skin, angles, pose, live[skin.index]) for skin in self._skins]

    def _error(self, skin: SkinKeys, angles: TurnAngles, pose: np.ndarray, live: np.ndarray) -> tuple[float, float]:
        single, combined = keys_at(skin, dict(angles), live.shape)
        errors = (self._posed_error(skin, pose, keys, live) for keys in (single + combined, single))
        with_all, without = (skin.mm_per_metre * error for error in errors)
        return with_all, without

    def _posed_error(self, skin: SkinKeys, pose: np.ndarray, keys: np.ndarray, live: np.ndarray) -> float:
        """The largest distance on the posed skin, in mesh space: of a sample from the line between two others."""
        three = _sinew.KeptSamples(
            self._sampler.skin(skin.index),
            np.array((pose, pose, pose)),
            np.array((keys, live, keys)),
            np.arange(3.0),
            np.zeros(3),
            np.array((True, False, True)),
        )
        return float(three.errors[1])


def keys_at(skin: SkinKeys, angles: dict[JointTurn, float], shape: tuple) -> tuple[np.ndarray, np.ndarray]:
    """The sum of a mesh's keys of single turns, and of its combined keys, where turns have these angles; others have 0."""
    single, combined = np.zeros(shape, np.float32), np.zeros(shape, np.float32)
    for turn, angle in angles.items():
        keys = skin.single[turn]
        for index in range(len(keys)):
            value = _value(tent_at(turn, keys.at, index), angle)
            if value:
                single += np.float32(value) * keys.correction(index)
    for first, second, pair in skin.pairs:
        if first in angles and second in angles:
            for index, (row, column) in enumerate(pair.corners):
                value = _value(tent_at(first, pair.first_at, row), angles[first])
                value *= _value(tent_at(second, pair.second_at, column), angles[second])
                if value:
                    combined += np.float32(value) * pair.correction(index)
    return single, combined


def _value(tent: TentWeight, angle: float) -> float:
    """The value of a tent weight, as its driver computes it."""
    rise = (angle - tent.inner) / (tent.peak - tent.inner)
    if tent.outer is None:
        return min(max(rise, 0.0), 1.0)
    return max(0.0, min(rise, (angle - tent.outer) / (tent.peak - tent.outer)))


def _samples_of(turns: list[JointTurn]) -> list[tuple[float, float, float]]:
    """Samples (direction, radius, twist) of a joint's range: direction in radians, radius 0..1, twist -1..1 of its ends."""
    swings = [turn for turn in turns if not turn.is_twist]
    twists = (-1.0, 0.0, 1.0) if len(swings) < len(turns) else (0.0,)
    directions = [2.0 * math.pi * index / _DIRECTIONS for index in range(_DIRECTIONS)]
    if len(swings) == 1:
        directions = [0.0, math.pi]
    return [
        (direction, radius, twist)
        for direction, twist in product(directions, twists)
        for radius in (_TWISTED_RADII if twist else _RADII)
    ]


def _around(sample: tuple[float, float, float], step: float, turns: list[JointTurn]) -> list[tuple[float, float, float]]:
    """The neighbours of a sample. A joint with one swing has two directions only."""
    direction, radius, twist = sample
    turned = 0.5 * math.pi * step if len([turn for turn in turns if not turn.is_twist]) > 1 else 0.0
    return [
        (direction + d * turned, min(max(radius + r * step, 0.0), 1.0), min(max(twist + t * step, -1.0), 1.0))
        for d, r, t in ((1, 0, 0), (-1, 0, 0), (0, 1, 0), (0, -1, 0), (0, 0, 1), (0, 0, -1))
        if twist or not t
    ]


def _angles_at(turns: list[JointTurn], direction: float, radius: float, twist: float) -> TurnAngles:
    """The angles of a joint's turns, in radians, where the half sines of its swings are on an ellipse."""
    angles: TurnAngles = []
    parts = [math.cos(direction), math.sin(direction)]
    for turn in turns:
        if turn.is_twist:
            angles.append((turn, twist * turn.high if twist > 0.0 else -twist * turn.low))
            continue
        part = parts.pop(0)
        end = turn.high if part > 0.0 else turn.low
        half = radius * abs(part) * math.sin(0.5 * abs(end))
        angles.append((turn, math.copysign(2.0 * math.asin(half), end)))
    return angles
