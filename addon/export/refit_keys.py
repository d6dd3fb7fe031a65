# SPDX-License-Identifier: GPL-3.0-or-later
"""Baked keys made to fit a copy whose muscles are bones: what its weights already do is taken out of them.

A baked key holds what is to be added before the character's own Armature modifier. On a copy of other weights the same place asks
for another offset, which its linear skin says exactly; of that, the key's part is what the other keys leave at its own pose.
"""

import re
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass

import bpy
import _sinew
import numpy as np

from ..bake.scratch import joint_turns

_FRAME = re.compile(r"-?\d+(\.\d+)?$")
# a key that acts less than this at its own pose says nothing about it
_LEAST_VALUE = 0.5
# m: shorter offsets become 0, so that a file keeps a key sparse
_PRUNED_M = 2e-6


@dataclass(frozen=True)
class Pose:
    """Where a baked key is exact: in a frame, or with these joints turned from the rest pose."""

    frame: float | None
    turns: list[tuple[joint_turns.Motion, float]]


def pose_of(baked) -> Pose | None:
    """The pose of one of `skin.sinew.baked_keys`; None where it is not known."""
    if baked.pose:
        return Pose(None, joint_turns.turns_in(baked.pose))
    number = _FRAME.search(baked.name)
    return None if baked.joints or number is None else Pose(float(number[0]), [])


@contextmanager
def resting(rig, ours: frozenset[str]) -> Iterator[Callable]:
    """A rig at rest while the context lasts, and what turns bones from there; constraints on others than `ours` rest."""
    channels = ("rotation_mode", "location", "rotation_quaternion", "rotation_euler", "rotation_axis_angle", "scale")
    before = [{name: _value(bone, name) for name in channels} for bone in rig.pose.bones]
    muted = [
        constraint
        for bone in rig.pose.bones
        if bone.name not in ours
        for constraint in bone.constraints
        if not constraint.mute
    ]
    for constraint in muted:
        constraint.mute = True
    for bone in rig.pose.bones:
        bone.rotation_mode = "QUATERNION"
        bone.matrix_basis.identity()
    turned: list[str] = []

    def turn(turns: list[tuple[joint_turns.Motion, float]]):
        for name in turned:
            rig.pose.bones[name].rotation_quaternion.identity()
        turned[:] = dict.fromkeys(motion.bone for motion, _ in turns)
        for name in turned:
            own = [turn for turn in turns if turn[0].bone == name]
            rig.pose.bones[name].rotation_quaternion = joint_turns.rotation_of(own)
        bpy.context.view_layer.update()

    try:
        yield turn
    finally:
        for constraint in muted:
            constraint.mute = False
        for bone, values in zip(rig.pose.bones, before, strict=True):
            for name, value in values.items():
                setattr(bone, name, value)


def _value(bone, name: str):
    found = getattr(bone, name)
    return found if isinstance(found, str) else tuple(found)


class KeyRefit:
    """The baked keys of one copied mesh, and what is known of them anew."""

    def __init__(self, copy, skin: _sinew.LinearSkin, rest: np.ndarray, names: list[str]):
        """names: of the baked keys, in the order in which they are made to fit. rest: (vertices, 3) float32."""
        self._copy, self._skin, self._rest = copy, skin, rest
        self._offsets: dict[str, np.ndarray] = {}
        self._order = names

    def fit(self, name: str, pose: np.ndarray, target: np.ndarray):
        """Makes a key fit the pose that the copy shows now, in which the skin is to be at `target`; those before it fit already."""
        needed = np.empty_like(self._rest)
        self._skin.correct(pose, target, needed)
        keys = self._copy.data.shape_keys.key_blocks
        for other, offset in self._offsets.items():
            if keys[other].value:
                needed -= keys[other].value * offset
        own = keys[name].value
        if own < _LEAST_VALUE:
            return
        needed /= own
        needed[np.linalg.norm(needed, axis=1) < _PRUNED_M] = 0.0
        self._offsets[name] = needed

    def write(self) -> Iterator[str]:
        """Writes the keys; returns those that could not be made to fit, which are muted."""
        keys = self._copy.data.shape_keys.key_blocks
        for name in self._order:
            offset = self._offsets.get(name)
            if offset is None:
                keys[name].mute = True
                yield name
            else:
                keys[name].points.foreach_set("co", (self._rest + offset).reshape(-1))
