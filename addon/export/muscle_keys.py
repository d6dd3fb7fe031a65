# SPDX-License-Identifier: GPL-3.0-or-later
"""Animation of an export copy's muscle bones: keyframes for what their constraints can't reproduce."""

import bpy
import numpy as np
from mathutils import Matrix, Quaternion

from ..bake.keys.value_curves import LINEAR
from .muscle_bones import MuscleBone

_CHANNELS = (("location", 3), ("rotation_quaternion", 4), ("scale", 3))
# The fraction of its length that a belly gives to the tendons at full tension; the same value as in the core.
TENSION_SHORTENING = 0.3


def key_bones(curves, rig, names: list[str], times: list[float], poses: np.ndarray):
    """Animates location, rotation and scale of bones, without constraints and in the rotation mode "QUATERNION".

    curves: from `copy_curves`. rig: the copy. names: the bones. times: of the frames, with Time Remapping.
    poses: (frames, bones, 4, 4) column-major, of the copy, in the order of its pose bones.
    """
    index_of_bone = {bone.name: index for index, bone in enumerate(rig.pose.bones)}
    for name in names:
        bone = rig.data.bones[name]
        index = index_of_bone[name]
        above = index_of_bone[bone.parent.name] if bone.parent else None
        bases = []
        for pose in poses:
            parent = {}
            if above is not None:
                parent = {"parent_matrix": _matrix(pose[above]), "parent_matrix_local": bone.parent.matrix_local}
            bases.append(bone.convert_local_to_pose(_matrix(pose[index]), bone.matrix_local, **parent, invert=True))
        path = f'pose.bones["{bpy.utils.escape_identifier(name)}"].'
        _write(curves, path, _CHANNELS, times, _components(bases))


def key_object(curves, times: list[float], worlds: list[Matrix]):
    """Animates location, rotation and scale of an object without parent, in the rotation mode "QUATERNION"."""
    _write(curves, "", _CHANNELS, times, _components(worlds))


def _components(transforms: list[Matrix]) -> np.ndarray:
    """Location, rotation and scale of transforms, (frames, 10)."""
    values = np.empty((len(transforms), 10))
    before = Quaternion()
    for row, transform in enumerate(transforms):
        location, rotation, scale = transform.decompose()
        if rotation.dot(before) < 0.0:
            rotation.negate()  # the same rotation, close to the last, so that interpolation takes the short path
        before = rotation
        values[row] = (*location, *rotation, *scale)
    return values


def hold_tension(rig, muscle: MuscleBone, tension: float):
    """Thickens a muscle bone for a tension that is the same in all frames. See `key_tension`."""
    across, along, _ = _thickened(np.array([tension]))[0]
    rig.pose.bones[muscle.origin].scale = (across, along, across)


def key_tension(curves, muscle: MuscleBone, times: list[float], tension: np.ndarray):
    """Thickens a muscle bone with its muscle's tension, by animating the scale of its origin helper. tension: (frames,)."""
    path = f'pose.bones["{bpy.utils.escape_identifier(muscle.origin)}"].'
    _write(curves, path, (("scale", 3),), times, _thickened(tension))


def _thickened(tension: np.ndarray) -> np.ndarray:
    """Returns the scale of a tense belly along x, y and z, (frames, 3): shorter along y, at constant volume."""
    along = 1.0 - TENSION_SHORTENING * tension
    return np.stack((along**-0.5, along, along**-0.5), axis=1)


def _matrix(column_major: np.ndarray) -> Matrix:
    return Matrix(column_major.T.tolist())


def _write(curves, path: str, channels: tuple, times: list[float], values: np.ndarray):
    """Writes the curves of channels. path: what precedes their names. values: (frames, components of all channels)."""
    column = 0
    for name, width in channels:
        for index in range(width):
            curve = curves.new(f"{path}{name}", index=index)
            points = curve.keyframe_points
            points.add(len(times))
            points.foreach_set("co", np.stack((times, values[:, column]), axis=1).reshape(-1))
            points.foreach_set("interpolation", np.full(len(times), LINEAR))
            curve.update()
            column += 1


def copy_curves(rig):
    """Copies the action that the copy plays, so that the character's does not change, and returns its curves.

    An action that nothing else plays is not copied again.
    """
    animation = rig.animation_data or rig.animation_data_create()
    if animation.action is None:
        action = bpy.data.actions.new(f"{rig.name} Action")
        slot = action.slots.new("OBJECT", rig.name)
    else:
        played = animation.action_slot.identifier
        action = animation.action.copy() if animation.action.users > 1 else animation.action
        slot = next(slot for slot in action.slots if slot.identifier == played)
    animation.action, animation.action_slot = action, slot
    if not action.layers:
        action.layers.new("Layer").strips.new(type="KEYFRAME")
    return action.layers[0].strips[0].channelbag(slot, ensure=True).fcurves
