# SPDX-License-Identifier: GPL-3.0-or-later
"""What a pose bone may do as a joint: its freedoms, limits, locks and eagerness, read from Blender's own settings.

Where Limit Rotation constraints (local space) or locked Euler channels limit it, its angles are Euler angles, in which those
limits are a box; where IK limits, IK locks or other locks do, swing and twist, which is what Blender's IK means by them; else it
is a ball joint without limits. Where both kinds are set on one bone, IK limits are taken as Euler angles, too. A locked angle keeps
its present value. IK stiffness lessens the eagerness of the whole joint, by its mean.

A bone that something else turns (another constraint, an IK chain) stays as that leaves it.
"""

import math
from dataclasses import dataclass

import _sinew
from mathutils import Euler, Quaternion

# more than an angle can get to in one reach; arrays are finite
NO_LIMIT_RAD = 100.0
# beyond a right angle, Blender's Limit Rotation reads the same rotation as other Euler angles
MIDDLE_AXIS_RAD = math.radians(89.9)
# between unit quaternions in float32
SAME_ROTATION = 1e-7
EULER_ORDERS = ("XYZ", "XZY", "YXZ", "YZX", "ZXY", "ZYX")
# what never turns a bone
_HARMLESS = {"LIMIT_ROTATION", "LIMIT_LOCATION", "LIMIT_SCALE", "LIMIT_DISTANCE", "MAINTAIN_VOLUME"}
_LEAST_MULTIPLIER, _GREATEST_MULTIPLIER = 0.1, 2.5


@dataclass(frozen=True)
class JointOfBone:
    """A pose bone as a joint. Angles in radians, three each; `freedoms` and their meaning as in `_sinew.Linkage`."""

    freedoms: str
    angles: tuple[float, float, float]
    lower: tuple[float, float, float]
    upper: tuple[float, float, float]
    multiplier: float


def driven_bones(rig) -> set[str]:
    """The bones of a rig that something else turns than their own channels: reaching leaves them alone."""
    driven = set()
    for bone in rig.pose.bones:
        for constraint in filter(_acts, bone.constraints):
            if constraint.type in ("IK", "SPLINE_IK"):
                driven.update(_chain_of_constraint(bone, constraint))
            elif constraint.type not in _HARMLESS or _limits_elsewhere(constraint):
                driven.add(bone.name)
    return driven


def rotation_of(bone) -> Quaternion:
    """The rotation of a pose bone by its own channels, whatever its rotation mode."""
    match bone.rotation_mode:
        case "QUATERNION":
            return bone.rotation_quaternion.normalized()
        case "AXIS_ANGLE":
            angle, *axis = bone.rotation_axis_angle
            return Quaternion(axis, angle)
        case _:
            return bone.rotation_euler.to_quaternion()


def joint_of(bone) -> JointOfBone:
    """A pose bone as a joint, in its present pose."""
    limit_rotations = [found for found in bone.constraints if _acts(found) and found.type == "LIMIT_ROTATION"]
    locked = _locked_axes(bone)
    ik_limits = [_ik_limit(bone, axis) for axis in "xyz"]
    is_euler = bone.rotation_mode in EULER_ORDERS
    if limit_rotations or (is_euler and any(bone.lock_rotation)):
        freedoms = _euler_order(bone, limit_rotations)
    elif any(locked) or any(ik_limits):
        freedoms = "SWING_TWIST"
    else:
        freedoms = "BALL"
    if freedoms == bone.rotation_mode:
        angles = tuple(bone.rotation_euler)
    else:
        near = tuple(bone.rotation_euler) if is_euler and freedoms in EULER_ORDERS else (0.0, 0.0, 0.0)
        angles = _sinew.joint_angles(freedoms, tuple(rotation_of(bone)), near)
    limits = [(-NO_LIMIT_RAD, NO_LIMIT_RAD)] * 3
    if freedoms == "SWING_TWIST":
        limits = [(-math.pi, math.pi), limits[1], (-math.pi, math.pi)]
    if limit_rotations:
        middle = "XYZ".index(freedoms[1])
        limits[middle] = (-MIDDLE_AXIS_RAD, MIDDLE_AXIS_RAD)
    for axis in range(3):
        wanted = [found for found in (ik_limits[axis], *(_limit(each, "xyz"[axis]) for each in limit_rotations)) if found]
        for low, high in wanted:
            # limits that exclude each other leave the later one
            low_now, high_now = max(limits[axis][0], low), min(limits[axis][1], high)
            limits[axis] = (low_now, high_now) if low_now <= high_now else (low, high)
        if locked[axis]:
            limits[axis] = (angles[axis], angles[axis])
    stiffness = [getattr(bone, f"ik_stiffness_{axis}") for axis, lock in zip("xyz", locked, strict=True) if not lock]
    eagerness = 1.0 - sum(stiffness) / len(stiffness) if stiffness else 1.0
    return JointOfBone(
        freedoms=freedoms,
        angles=angles,
        lower=tuple(low for low, _ in limits),
        upper=tuple(high for _, high in limits),
        multiplier=min(max(bone.sinew.multiplier * eagerness, _LEAST_MULTIPLIER), _GREATEST_MULTIPLIER),
    )


def write(bone, freedoms: str, angles) -> bool:
    """Turns a pose bone to the angles of its joint, in its own rotation mode, near to where it was; False: it is there already."""
    rotation, present = Quaternion(_sinew.joint_rotation(freedoms, angles)), rotation_of(bone)
    if min((rotation - present).magnitude, (rotation + present).magnitude) < SAME_ROTATION:
        return False
    match bone.rotation_mode:
        case "QUATERNION":
            # of the two quaternions of a rotation the nearer one, so that keys between them turn the short way
            bone.rotation_quaternion = rotation if bone.rotation_quaternion.dot(rotation) >= 0.0 else -rotation
        case "AXIS_ANGLE":
            _, *before = bone.rotation_axis_angle
            axis, angle = rotation.to_axis_angle()
            turn = 1.0 if sum(a * b for a, b in zip(axis, before, strict=True)) >= 0.0 else -1.0
            bone.rotation_axis_angle = (turn * angle, *(turn * axis))
        case order if order == freedoms:
            bone.rotation_euler = angles
        case order:
            bone.rotation_euler = rotation.to_euler(order, bone.rotation_euler)
    return True


def rotation_path(bone) -> str:
    """The property that a pose bone's rotation mode uses."""
    return {"QUATERNION": "rotation_quaternion", "AXIS_ANGLE": "rotation_axis_angle"}.get(
        bone.rotation_mode, "rotation_euler"
    )


def rest_angles(joint: JointOfBone) -> tuple[float, float, float]:
    """The angles of the rest pose, as near to it as the joint's limits and locks allow."""
    return tuple(min(max(0.0, low), high) for low, high in zip(joint.lower, joint.upper, strict=True))


def turned(joint: JointOfBone, axis: int, angle: float) -> tuple[float, float, float]:
    """The angles after turning about an axis (0 x, 1 y, 2 z), within the joint's limits."""
    if joint.freedoms == "BALL":
        about = [0.0, 0.0, 0.0]
        about[axis] = angle
        both = Quaternion(_sinew.joint_rotation("BALL", joint.angles)) @ Euler(about).to_quaternion()
        return _sinew.joint_angles("BALL", tuple(both), joint.angles)
    angles = list(joint.angles)
    angles[axis] = min(max(angles[axis] + angle, joint.lower[axis]), joint.upper[axis])
    return tuple(angles)


def _acts(constraint) -> bool:
    return not constraint.mute and constraint.influence > 0.0 and constraint.is_valid


def _chain_of_constraint(bone, constraint) -> list[str]:
    """The bones that an IK constraint turns."""
    chain = [bone, *bone.parent_recursive]
    if constraint.type == "IK" and not constraint.use_tail:
        chain = chain[1:]
    return [found.name for found in (chain[: constraint.chain_count] if constraint.chain_count else chain)]


def _limits_elsewhere(constraint) -> bool:
    return constraint.type == "LIMIT_ROTATION" and constraint.owner_space != "LOCAL"


def _locked_axes(bone) -> list[bool]:
    locks = [lock or getattr(bone, f"lock_ik_{axis}") for lock, axis in zip(bone.lock_rotation, "xyz", strict=True)]
    if bone.rotation_mode not in EULER_ORDERS and bone.lock_rotations_4d and bone.lock_rotation_w:
        return [True] * 3  # three numbers of four can't change alone
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
