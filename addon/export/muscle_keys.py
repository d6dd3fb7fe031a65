# SPDX-License-Identifier: GPL-3.0-or-later
"""Keys on an export copy's muscle bones: what their constraints can't say, frame by frame."""

import bpy
import numpy as np
from mathutils import Matrix, Quaternion

from .muscle_bones import MuscleBone

_CHANNELS = (("location", 3), ("rotation_quaternion", 4), ("scale", 3))
_LINEAR = 1  # of a keyframe's interpolations
# share of its length that a belly gives to the tendons at full tension, as the core has it
TENSION_SHORTENING = 0.3


def key_bones(curves, rig, muscles: list[MuscleBone], frames: list[int], poses: np.ndarray):
    """Keys location, rotation and scale of muscles' bones.

    curves: as from `own_curves`. rig: the copy. poses: (frames, bones, 4, 4) column-major, of the copy, in the order of its
    pose bones.
    """
    places = {bone.name: place for place, bone in enumerate(rig.pose.bones)}
    for muscle in muscles:
        bone = rig.data.bones[muscle.bone]
        to_parent = bone.matrix_local.inverted() @ bone.parent.matrix_local
        own, parent = places[bone.name], places[bone.parent.name]
        values = np.empty((len(frames), 10))
        before = Quaternion()
        for row, pose in enumerate(poses):
            basis = to_parent @ _matrix(pose[parent]).inverted() @ _matrix(pose[own])
            location, rotation, scale = basis.decompose()
            if rotation.dot(before) < 0.0:
                rotation.negate()  # the same turn, without a way round between two keys
            before = rotation
            values[row] = (*location, *rotation, *scale)
        _write(curves, muscle.bone, _CHANNELS, frames, values)


def hold_tension(rig, muscle: MuscleBone, tension: float):
    """The same as `key_tension` for a muscle that is as tense in all frames."""
    across, along, _ = _thickened(np.array([tension]))[0]
    rig.pose.bones[muscle.origin].scale = (across, along, across)


def key_tension(curves, muscle: MuscleBone, frames: list[int], tension: np.ndarray):
    """Lets a muscle bone thicken as its muscle is tense: by the scale of its helper at the origin. tension: (frames,)."""
    _write(curves, muscle.origin, (("scale", 3),), frames, _thickened(tension))


def _thickened(tension: np.ndarray) -> np.ndarray:
    """(frames, 3): scale across, along and across a belly of unchanged length and volume."""
    along = 1.0 - TENSION_SHORTENING * tension
    return np.stack((along**-0.5, along, along**-0.5), axis=1)


def _matrix(column_major: np.ndarray) -> Matrix:
    return Matrix(column_major.T.tolist())


def _write(curves, bone: str, channels: tuple, frames: list[int], values: np.ndarray):
    """Writes curves of a bone's channels. values: (frames, all components of the channels)."""
    path = f'pose.bones["{bpy.utils.escape_identifier(bone)}"]'
    column = 0
    for name, width in channels:
        for index in range(width):
            curve = curves.new(f"{path}.{name}", index=index)
            points = curve.keyframe_points
            points.add(len(frames))
            points.foreach_set("co", np.stack((frames, values[:, column]), axis=1).reshape(-1))
            points.foreach_set("interpolation", np.full(len(frames), _LINEAR))
            curve.update()
            column += 1


def own_curves(rig):
    """The curves of an action of the copy's own, in which all that it played stays: the character's action must stay as it is."""
    animation = rig.animation_data or rig.animation_data_create()
    if animation.action is None:
        action = bpy.data.actions.new(f"{rig.name} Action")
        slot = action.slots.new("OBJECT", rig.name)
    else:
        played = animation.action_slot.identifier
        action = animation.action.copy()
        slot = next(slot for slot in action.slots if slot.identifier == played)
    animation.action, animation.action_slot = action, slot
    if not action.layers:
        action.layers.new("Layer").strips.new(type="KEYFRAME")
    return action.layers[0].strips[0].channelbag(slot, ensure=True).fcurves
