# SPDX-License-Identifier: GPL-3.0-or-later
"""The axes and ranges of a joint's turns: read from the user's text, or else from the bone's locks and limits.

The defaults are described in docs/mathematics/baking.md, Joint turns.
"""

import math
import re

from mathutils import Vector

from ...errors import SinewError
from ...measure import joint_regions
from ...reach import bone_limits
from ...scene import bone_geometry
from ..scratch.joint_turns import AXES, BEND, JointTurn

# ranges where neither the user nor the bone's limits give any
HINGE_DEGREES, SWING_DEGREES, TWIST_DEGREES = 150.0, 90.0, 60.0
FARTHEST_DEGREES = 175.0
# A muscle axis this close to the bone's X or Z axis is replaced by that axis.
SNAP_DEGREES = 20.0
_LEAST_DEGREES = 1.0
_RANGE = re.compile(r"(?:([XYZ])\s+)?(-?\d+(?:\.\d*)?)\s*\.\.\s*(-?\d+(?:\.\d*)?)(?:\s+|$)", re.IGNORECASE)


def turns_of_joint(rig, joint: joint_regions.Joint, ranges: str, twists: bool) -> list[JointTurn]:
    """Returns the turns of a joint.

    ranges: see `parse_ranges`. If it is empty, the bone's locks and limits decide: a hinge bends about the muscle axis,
    another joint swings about X and Z, and both twist if `twists`.
    """
    bend_axis, direction = _muscle_axis(rig, joint)
    if ranges:
        return [
            JointTurn(joint.bone, axis, tuple(AXES[axis]), math.radians(low), math.radians(high))
            if axis
            else _bend(joint.bone, bend_axis, direction, math.radians(low), math.radians(high))
            for axis, low, high in parse_ranges(ranges)
        ]
    limited = bone_limits.joint_of(rig.pose.bones[joint.bone])
    limits = [(limited.lower[index], limited.upper[index]) for index in range(3)]
    if joint.bends_one_way and not any(_is_limited(limits[index]) for index in (0, 2)):
        turns = [_bend(joint.bone, bend_axis, direction, 0.0, math.radians(HINGE_DEGREES))]
        twists = twists and _is_limited(limits[1])  # hinges such as a knee do not twist, unless their limits say so
    else:
        turns = [_within_limits(joint.bone, axis, limits["XYZ".index(axis)], SWING_DEGREES) for axis in "XZ"]
    if twists:
        turns.append(_within_limits(joint.bone, "Y", limits[1], TWIST_DEGREES))
    return [turn for turn in turns if turn.high - turn.low >= math.radians(_LEAST_DEGREES)]


def parse_ranges(text: str) -> list[tuple[str, float, float]]:
    """Reads a text such as "0..150" or "X -20..150 Y -80..80".

    Returns the axis of each range ("X", "Y", "Z", or "" for the muscle axis) with its first and last angle in degrees.
    Raises SinewError if the text is malformed.
    """
    ranges, position = [], 0
    stripped = text.strip()
    while position < len(stripped):
        match = _RANGE.match(stripped, position)
        if match is None:
            raise SinewError(
                f"'{text}' is not a range of angles: write '0..150', or 'X -20..150 Y -80..80' for the bone's axes"
            )
        axis, low, high = (match[1] or "").upper(), float(match[2]), float(match[3])
        if not -FARTHEST_DEGREES <= low <= 0.0 <= high <= FARTHEST_DEGREES or low == high:
            raise SinewError(
                f"'{match[0].strip()}' must contain 0, the rest pose, and end at {FARTHEST_DEGREES:.0f} degrees or less"
            )
        ranges.append((axis, low, high))
        position = match.end()
    axes = [axis for axis, _, _ in ranges]
    if len(set(axes)) < len(axes) or ("" in axes and {"X", "Z"} & set(axes)):
        raise SinewError(f"'{text}' names an axis twice: a range without an axis can only be combined with Y")
    return ranges


def named_bones(rig, names: str) -> list[str]:
    """Reads the names of bones, separated by commas. Raises SinewError for a bone that is missing or has no parent."""
    listed = [name.strip() for name in names.split(",") if name.strip()]
    for name in listed:
        if not bone_geometry.has_bone(rig, name):
            raise SinewError(f"{rig.name} has no bone '{name}': write names of its bones, separated by commas")
        if rig.data.bones[name].parent is None:
            raise SinewError(f"'{name}' has no parent, so there is no joint at its head: name another bone")
    return list(dict.fromkeys(listed))


def _muscle_axis(rig, joint: joint_regions.Joint) -> tuple[str, Vector]:
    """Returns name and direction of the axis across the bone that muscles bend it about, or X or Z if that is close."""
    direction = rig.data.bones[joint.bone].matrix_local.to_3x3().inverted() @ joint.axis
    direction.y = 0.0
    if direction.length < 1e-3:
        return "X", AXES["X"]
    direction.normalize()
    for axis in "XZ":
        bone_axis = AXES[axis]
        if abs(direction.dot(bone_axis)) > math.cos(math.radians(SNAP_DEGREES)):
            return axis, bone_axis if direction.dot(bone_axis) > 0.0 else -bone_axis
    return BEND, direction


def _bend(bone: str, axis: str, direction: Vector, low: float, high: float) -> JointTurn:
    """Returns a bend about a direction. If that is the negative X or Z axis, the range is negated instead of the axis."""
    if axis == BEND or direction.dot(AXES[axis]) > 0.0:
        return JointTurn(bone, axis, tuple(direction), low, high)
    return JointTurn(bone, axis, tuple(AXES[axis]), -high, -low)


def _is_limited(limits: tuple[float, float]) -> bool:
    return limits[0] > -math.pi or limits[1] < math.pi


def _within_limits(bone: str, axis: str, limits: tuple[float, float], degrees: float) -> JointTurn:
    """Returns a turn about a bone's axis to its limits, or else by `degrees`. The range contains the rest pose."""
    farthest, unlimited = math.radians(FARTHEST_DEGREES), math.radians(degrees)
    low = min(max(limits[0], -farthest), 0.0) if limits[0] > -math.pi else -unlimited
    high = max(min(limits[1], farthest), 0.0) if limits[1] < math.pi else unlimited
    return JointTurn(bone, axis, tuple(AXES[axis]), low, high)
