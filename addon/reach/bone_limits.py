# SPDX-License-Identifier: GPL-3.0-or-later
"""Pose bones as joints: degrees of freedom, limits, locks and eagerness, read from Blender's settings.

The settings of a bone choose the angles of its joint. With Limit Rotation constraints (local space) or locked Euler channels
the angles are Euler angles, because these limits are a box in Euler angles. With IK limits, IK locks or other locks they are
swing and twist, as in Blender's IK. With both kinds, IK limits apply to the Euler angles. Without any, the joint is a ball
joint without limits. A locked angle keeps its current value. The mean of the IK stiffness of the unlocked axes reduces the
eagerness of the joint.

Reaching does not rotate a bone that another constraint or an IK chain controls.
"""

import math
from dataclasses import dataclass

import _sinew
from mathutils import Euler, Quaternion

from ..scene import stored_settings

# A finite value for "no limit": no angle gets this large in one reach.
NO_LIMIT_RAD = 100.0
# Beyond a right angle of the middle axis, Blender's Limit Rotation reads the same rotation as other Euler angles.
MIDDLE_AXIS_RAD = math.radians(89.9)
# Distance between unit quaternions, float32, that counts as the same rotation.
SAME_ROTATION = 1e-7
EULER_ORDERS = ("XYZ", "XZY", "YXZ", "YZX", "ZXY", "ZYX")
# Constraints that never rotate a bone by themselves.
_HARMLESS = {"LIMIT_ROTATION", "LIMIT_LOCATION", "LIMIT_SCALE", "LIMIT_DISTANCE", "MAINTAIN_VOLUME"}
SMALLEST_EAGERNESS, _LARGEST_EAGERNESS = 0.1, 2.5


@dataclass(frozen=True)
class BoneJoint:
    """A pose bone as a joint. Angles are radians; their meaning depends on `parameterisation` as in `_sinew.Linkage`."""

    parameterisation: str
    angles: tuple[float, float, float]
    lower: tuple[float, float, float]
    upper: tuple[float, float, float]
    eagerness: float


def driven_bones(rig) -> set[str]:
    """The names of the bones that constraints rotate. Reaching does not rotate them."""
    driven = set()
    for bone in rig.pose.bones:
        for constraint in filter(_acts, bone.constraints):
            if constraint.type in ("IK", "SPLINE_IK"):
                driven.update(_chain_of_constraint(bone, constraint))
            elif constraint.type not in _HARMLESS or _limits_elsewhere(constraint):
                driven.add(bone.name)
    return driven


def rotation_of(bone) -> Quaternion:
    """The rotation of a pose bone by its rotation channels, in any rotation mode."""
    match bone.rotation_mode:
        case "QUATERNION":
            return bone.rotation_quaternion.normalized()
        case "AXIS_ANGLE":
            angle, *axis = bone.rotation_axis_angle
            return Quaternion(axis, angle)
        case _:
            return bone.rotation_euler.to_quaternion()


def joint_of(bone) -> BoneJoint:
    """A pose bone as a joint, in its current pose."""
    limit_rotations = [each for each in bone.constraints if _acts(each) and each.type == "LIMIT_ROTATION"]
    locked = _locked_axes(bone)
    ik_limits = [_ik_limit(bone, axis) for axis in "xyz"]
    is_euler = bone.rotation_mode in EULER_ORDERS
    if limit_rotations or (is_euler and any(bone.lock_rotation)):
        parameterisation = _euler_order(bone, limit_rotations)
    elif any(locked) or any(ik_limits):
        parameterisation = "SWING_TWIST"
    else:
        parameterisation = "BALL"
    if parameterisation == bone.rotation_mode:
        angles = tuple(bone.rotation_euler)
    else:
        near = tuple(bone.rotation_euler) if is_euler and parameterisation in EULER_ORDERS else (0.0, 0.0, 0.0)
        angles = _sinew.joint_angles(parameterisation, tuple(rotation_of(bone)), near)
    limits = [(-NO_LIMIT_RAD, NO_LIMIT_RAD)] * 3
    if parameterisation == "SWING_TWIST":
        limits = [(-math.pi, math.pi), limits[1], (-math.pi, math.pi)]
    if limit_rotations:
        middle = "XYZ".index(parameterisation[1])
        limits[middle] = (-MIDDLE_AXIS_RAD, MIDDLE_AXIS_RAD)
    for axis in range(3):
        for limit in (ik_limits[axis], *(_limit(each, "xyz"[axis]) for each in limit_rotations)):
            if limit is None:
                continue
            # of two limits that exclude each other, the later one applies
            low, high = max(limits[axis][0], limit[0]), min(limits[axis][1], limit[1])
            limits[axis] = (low, high) if low <= high else limit
        if locked[axis]:
            limits[axis] = (angles[axis], angles[axis])
    stiffness = [getattr(bone, f"ik_stiffness_{axis}") for axis, lock in zip("xyz", locked, strict=True) if not lock]
    eagerness = 1.0 - sum(stiffness) / len(stiffness) if stiffness else 1.0
    settings = stored_settings.bone_of(bone)
    if settings is not None:
        eagerness *= settings.eagerness
    return BoneJoint(
        parameterisation=parameterisation,
        angles=angles,
        lower=tuple(low for low, _ in limits),
        upper=tuple(high for _, high in limits),
        eagerness=min(max(eagerness, SMALLEST_EAGERNESS), _LARGEST_EAGERNESS),
    )


def write(bone, parameterisation: str, angles) -> bool:
    """Rotates a pose bone to the angles of its joint, in its rotation mode. False: it has that rotation already.

    Of the values that mean the same rotation, the ones closest to the bone's current values are written.
    """
    rotation, present = Quaternion(_sinew.joint_rotation(parameterisation, angles)), rotation_of(bone)
    if min((rotation - present).magnitude, (rotation + present).magnitude) < SAME_ROTATION:
        return False
    match bone.rotation_mode:
        case "QUATERNION":
            # of the two quaternions of a rotation the closer one, so that interpolation takes the short way
            bone.rotation_quaternion = rotation if bone.rotation_quaternion.dot(rotation) >= 0.0 else -rotation
        case "AXIS_ANGLE":
            _, *before = bone.rotation_axis_angle
            axis, angle = rotation.to_axis_angle()
            sign = 1.0 if sum(a * b for a, b in zip(axis, before, strict=True)) >= 0.0 else -1.0
            bone.rotation_axis_angle = (sign * angle, *(sign * axis))
        case order if order == parameterisation:
            bone.rotation_euler = angles
        case order:
            bone.rotation_euler = rotation.to_euler(order, bone.rotation_euler)
    return True


def rotation_path(bone) -> str:
    """The name of the rotation property that a pose bone's rotation mode uses."""
    return {"QUATERNION": "rotation_quaternion", "AXIS_ANGLE": "rotation_axis_angle"}.get(
        bone.rotation_mode, "rotation_euler"
    )


def rest_angles(joint: BoneJoint) -> tuple[float, float, float]:
    """The angles of the rest pose, or the closest ones that the joint's limits and locks allow."""
    return tuple(min(max(0.0, low), high) for low, high in zip(joint.lower, joint.upper, strict=True))


def rotated_angles(joint: BoneJoint, axis: int, angle: float) -> tuple[float, float, float]:
    """The angles after a rotation about an axis of the bone (0 x, 1 y, 2 z) by an angle in radians, within the limits."""
    if joint.parameterisation == "BALL":
        euler = [0.0, 0.0, 0.0]
        euler[axis] = angle
        rotation = Quaternion(_sinew.joint_rotation("BALL", joint.angles)) @ Euler(euler).to_quaternion()
        return _sinew.joint_angles("BALL", tuple(rotation), joint.angles)
    angles = list(joint.angles)
    angles[axis] = min(max(angles[axis] + angle, joint.lower[axis]), joint.upper[axis])
    return tuple(angles)


def _acts(constraint) -> bool:
    """Whether a constraint has an effect."""
    return not constraint.mute and constraint.influence > 0.0 and constraint.is_valid


def _chain_of_constraint(bone, constraint) -> list[str]:
    """The names of the bones that an IK or Spline IK constraint rotates."""
    chain = [bone, *bone.parent_recursive]
    if constraint.type == "IK" and not constraint.use_tail:
        chain = chain[1:]
    return [each.name for each in (chain[: constraint.chain_count] if constraint.chain_count else chain)]


def _limits_elsewhere(constraint) -> bool:
    """Whether a constraint limits the rotation in other axes than the bone's, which a joint can't represent."""
    return constraint.type == "LIMIT_ROTATION" and constraint.owner_space != "LOCAL"


def _locked_axes(bone) -> list[bool]:
    locks = [lock or getattr(bone, f"lock_ik_{axis}") for lock, axis in zip(bone.lock_rotation, "xyz", strict=True)]
    if bone.rotation_mode not in EULER_ORDERS and bone.lock_rotations_4d and bone.lock_rotation_w:
        return [True] * 3  # with W locked, the other three numbers of a quaternion cannot change alone
    return locks


def _euler_order(bone, limit_rotations: list) -> str:
    orders = [limit.euler_order for limit in limit_rotations if limit.euler_order in EULER_ORDERS]
    if orders:
        return orders[0]
    return bone.rotation_mode if bone.rotation_mode in EULER_ORDERS else "XYZ"


def _ik_limit(bone, axis: str) -> tuple[float, float] | None:
    if not getattr(bone, f"use_ik_limit_{axis}"):
        return None
    return getattr(bone, f"ik_min_{axis}"), getattr(bone, f"ik_max_{axis}")


def _limit(constraint, axis: str) -> tuple[float, float] | None:
    if not getattr(constraint, f"use_limit_{axis}"):
        return None
    return getattr(constraint, f"min_{axis}"), getattr(constraint, f"max_{axis}")
