# SPDX-License-Identifier: GPL-3.0-or-later
"""Gives an export copy an armature without mirrored or sheared axes, where its character has such a scale in the world.

Let A be the linear part of the rig's transform to the world. Its singular value decomposition splits it exactly into

    A = U S W

with a rotation U, a scale S along the axes, and an orthogonal matrix W. W is applied to the armature: to its rest pose and,
where W mirrors, to the pose of every bone, which is then keyed. U and S are left to the copy's object. An uneven scale can't
be applied to bones: a bone that turns under it would be sheared, which no format can store.
"""

import re
from itertools import permutations, product

import bpy
import numpy as np
from mathutils import Matrix

from . import muscle_keys

_OBJECT_CHANNELS = frozenset(
    {"location", "rotation_euler", "rotation_quaternion", "rotation_axis_angle", "scale"}
    | {"delta_location", "delta_rotation_euler", "delta_rotation_quaternion", "delta_scale"}
)
# the channels of a bone whose sign changes where its X axis is mirrored
_MIRRORED_CHANNELS = frozenset(("LOC_X", "ROT_Y", "ROT_Z"))
_AS_EXPRESSION = {"SUM": "sum(({0},))", "AVERAGE": "sum(({0},))/{1}", "MIN": "min({0})", "MAX": "max({0})"}
_NAME = re.compile(r"\b[A-Za-z_]\w*\b")
_STRAIGHT = 1e-4  # relative to the largest scale
_SAME = 1e-6
_MIRROR = np.diag((-1.0, 1.0, 1.0))


def inner_of(world) -> np.ndarray:
    """The orthogonal matrix W, (3, 3), of a transform to the world, (4, 4): the identity if the scale is along the axes."""
    linear = np.array(world, np.float64)[:3, :3]
    mirrors = np.linalg.det(linear) < 0.0
    squared = linear.T @ linear
    if np.abs(squared - np.diag(np.diag(squared))).max() <= _STRAIGHT * squared.max():
        return _MIRROR if mirrors else np.eye(3)
    rows = np.linalg.svd(linear)[2]
    signs_of_rows = product((1, -1), repeat=3)
    choices = [np.array(signs)[:, None] * rows[list(order)] for signs in signs_of_rows for order in permutations(range(3))]
    sign = -1.0 if mirrors else 1.0
    return max((choice for choice in choices if np.linalg.det(choice) * sign > 0.0), key=np.trace)


def apply(rig_copy, copies: list, relations: list[Matrix], frames: list[int], worlds: np.ndarray, poses: np.ndarray):
    """Applies W to an export copy, which keeps its place and its pose in the world in each frame.

    rig_copy: the active object, in Object Mode. relations: the transforms of the meshes `copies` to the rig. worlds:
    (frames, 4, 4), the transforms of its rig to the world; that of the first frame gives W. poses: (frames, bones, 4, 4)
    float32, column-major, of the copy, in the order of its pose bones.
    """
    inner = inner_of(worlds[0])
    mirrors = np.linalg.det(inner) < 0.0
    applied = Matrix(inner.tolist()).to_4x4()
    if not np.allclose(inner, np.eye(3), atol=_SAME):
        _apply_to_rest(rig_copy, applied, mirrors)
        if mirrors:
            _key_pose(rig_copy, applied, frames, poses)
            for copy in copies:
                _mirror_drivers(copy.data.shape_keys, rig_copy)
    _place(rig_copy, frames, [Matrix(world.tolist()) @ applied.inverted() for world in worlds])
    for copy, relation in zip(copies, relations, strict=True):
        copy.animation_data_clear()
        copy.constraints.clear()
        copy.parent, copy.parent_type = rig_copy, "OBJECT"
        copy.matrix_parent_inverse = applied @ relation  # may mirror and shear
        copy.matrix_basis = Matrix()


def _apply_to_rest(rig_copy, applied: Matrix, mirrors: bool):
    flip = Matrix(_MIRROR.tolist()).to_4x4() if mirrors else Matrix()
    bpy.ops.object.mode_set(mode="EDIT")
    bones = rig_copy.data.edit_bones
    rest = {bone.name: bone.matrix.copy() for bone in bones}
    for bone in bones:
        bone.matrix = applied @ rest[bone.name] @ flip
    bpy.ops.object.mode_set(mode="OBJECT")


def _key_pose(rig_copy, applied: Matrix, frames: list[int], poses: np.ndarray):
    """Keys every bone with its mirrored pose. Constraints and drivers, which would pose the bones again, are removed."""
    animation = rig_copy.animation_data or rig_copy.animation_data_create()
    for curve in [curve for curve in animation.drivers if curve.data_path.startswith("pose.bones")]:
        animation.drivers.remove(curve)
    for track in list(animation.nla_tracks):
        animation.nla_tracks.remove(track)
    flip = Matrix(_MIRROR.tolist()).to_4x4()
    mirrored = np.einsum("ij,fbjk,kl->fbil", np.array(applied), poses.transpose(0, 1, 3, 2), np.array(flip))
    for bone in rig_copy.pose.bones:
        for constraint in list(bone.constraints):
            bone.constraints.remove(constraint)
        bone.rotation_mode = "QUATERNION"
        bone.matrix_basis = Matrix()
    curves = muscle_keys.copy_curves(rig_copy)
    for curve in [curve for curve in curves if curve.data_path.startswith("pose.bones")]:
        curves.remove(curve)
    muscle_keys.key_bones(
        curves, rig_copy, [bone.name for bone in rig_copy.pose.bones], frames, mirrored.transpose(0, 1, 3, 2)
    )


def _mirror_drivers(keys, rig_copy):
    """Makes the drivers of keys read the angles of the bones before these were mirrored: twist gets another sign."""
    animation = keys.animation_data if keys else None
    for curve in animation.drivers if animation else ():
        driver = curve.driver
        turned = {
            variable.name
            for variable in driver.variables
            if variable.type == "TRANSFORMS"
            and variable.targets[0].id == rig_copy
            and variable.targets[0].transform_type in _MIRRORED_CHANNELS
        }
        if turned and driver.type != "SCRIPTED":
            names = [variable.name for variable in driver.variables]
            driver.expression = _AS_EXPRESSION[driver.type].format(", ".join(names), len(names))
            driver.type = "SCRIPTED"
        if turned:
            driver.expression = _with_negative(driver.expression, turned)


def _with_negative(expression: str, names: set[str]) -> str:
    """An expression in which these variables have the other sign."""
    return _NAME.sub(lambda name: f"(-{name[0]})" if name[0] in names else name[0], expression)


def _place(rig_copy, frames: list[int], worlds: list[Matrix]):
    """Gives a copy without parent these transforms to the world, keyed where they change."""
    rig_copy.parent = None
    rig_copy.constraints.clear()
    rig_copy.delta_location, rig_copy.delta_scale = (0.0,) * 3, (1.0,) * 3
    rig_copy.delta_rotation_euler, rig_copy.delta_rotation_quaternion = (0.0,) * 3, (1.0, 0.0, 0.0, 0.0)
    rig_copy.rotation_mode = "QUATERNION"
    animation = rig_copy.animation_data
    if animation:
        for curve in [curve for curve in animation.drivers if curve.data_path in _OBJECT_CHANNELS]:
            animation.drivers.remove(curve)
    moves = any(np.abs(np.array(world) - np.array(worlds[0])).max() > _SAME for world in worlds)
    if moves or (animation and animation.action):
        curves = muscle_keys.copy_curves(rig_copy)
        for curve in [curve for curve in curves if curve.data_path in _OBJECT_CHANNELS]:
            curves.remove(curve)
        if moves:
            muscle_keys.key_object(curves, frames, worlds)
    rig_copy.matrix_basis = worlds[0]
