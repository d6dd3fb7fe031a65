# SPDX-License-Identifier: GPL-3.0-or-later
"""Refits baked keys to an export copy: what the copy's weights for muscle bones already do is taken out of the keys.

A baked key holds what has to be added before the character's Armature modifier. On a copy with other weights, the same
posed position requires another offset, which the copy's linear skin computes exactly. The key gets the part of that
offset that the other keys leave at its own pose.
"""

import re
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass

import bpy
import _sinew
import numpy as np

from ..bake.scratch import joint_turns
from ..bake.scratch.joint_turns import TurnAngles

_FRAME = re.compile(r"-?\d+(\.\d+)?$")
# A key with a smaller value at its own pose can't be refitted there.
_LEAST_VALUE = 0.5
# Shorter offsets become 0, m, so that keys stay sparse in a file.
_PRUNED_M = 2e-6


@dataclass(frozen=True)
class KeyPose:
    """The pose at which a baked key is exact: a frame, or joints turned from the rest pose."""

    frame: float | None
    angles: TurnAngles


def pose_of(baked) -> KeyPose | None:
    """Returns the pose of one of `skin.sinew.skin.baked_keys`, or None if it is not known."""
    if baked.pose:
        return KeyPose(None, joint_turns.from_json(baked.pose))
    number = _FRAME.search(baked.name)
    return None if baked.joints or number is None else KeyPose(float(number[0]), [])


@contextmanager
def rest_pose(rig, active: frozenset[str]) -> Iterator[Callable[[TurnAngles], None]]:
    """Brings a rig to its rest pose until the block ends. Only constraints of the bones `active` act.

    Yields a function that turns joints from the rest pose.
    """
    channels = ("rotation_mode", "location", "rotation_quaternion", "rotation_euler", "rotation_axis_angle", "scale")
    before = [{name: _value(bone, name) for name in channels} for bone in rig.pose.bones]
    muted = [
        constraint
        for bone in rig.pose.bones
        if bone.name not in active
        for constraint in bone.constraints
        if not constraint.mute
    ]
    for constraint in muted:
        constraint.mute = True
    for bone in rig.pose.bones:
        bone.rotation_mode = "QUATERNION"
        bone.matrix_basis.identity()
    rotated: list[str] = []

    def turn_joints(angles: TurnAngles):
        for name in rotated:
            rig.pose.bones[name].rotation_quaternion.identity()
        rotated[:] = dict.fromkeys(turn.bone for turn, _ in angles)
        for name in rotated:
            of_bone = [each for each in angles if each[0].bone == name]
            rig.pose.bones[name].rotation_quaternion = joint_turns.rotation_of(of_bone)
        bpy.context.view_layer.update()

    try:
        yield turn_joints
    finally:
        for constraint in muted:
            constraint.mute = False
        for bone, values in zip(rig.pose.bones, before, strict=True):
            for name, value in values.items():
                setattr(bone, name, value)


def _value(bone, name: str):
    value = getattr(bone, name)
    return value if isinstance(value, str) else tuple(value)


class KeyRefit:
    """The baked keys of one copied mesh and their new offsets."""

    def __init__(self, copy, skin: _sinew.LinearSkin, rest: np.ndarray, names: list[str]):
        """names: the baked keys in the order in which they are refitted. rest: (vertices, 3) float32, mesh space."""
        self._copy, self._skin, self._rest = copy, skin, rest
        self._offsets: dict[str, np.ndarray] = {}
        self._order = names

    def fit(self, name: str, pose: np.ndarray, target: np.ndarray):
        """Refits a key to the pose that the copy shows now. Keys that act there must be refitted before.

        pose: (bones, 4, 4) float32, column-major, of the copy. target: (vertices, 3) float32, the posed skin in mesh space.
        """
        needed = np.empty_like(self._rest)
        self._skin.correct(pose, target, needed)
        keys = self._copy.data.shape_keys.key_blocks
        for other, offset in self._offsets.items():
            if keys[other].value:
                needed -= keys[other].value * offset
        value = keys[name].value
        if value < _LEAST_VALUE:
            return
        needed /= value
        needed[np.linalg.norm(needed, axis=1) < _PRUNED_M] = 0.0
        self._offsets[name] = needed

    def write(self) -> Iterator[str]:
        """Writes the keys. Mutes keys that were not refitted and yields their names."""
        keys = self._copy.data.shape_keys.key_blocks
        for name in self._order:
            offset = self._offsets.get(name)
            if offset is None:
                keys[name].mute = True
                yield name
            else:
                keys[name].points.foreach_set("co", (self._rest + offset).reshape(-1))
