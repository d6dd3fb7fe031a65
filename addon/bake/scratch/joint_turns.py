# SPDX-License-Identifier: GPL-3.0-or-later
"""How the joints of a rig are turned for correctives, and how a pose is read back from a bone: as swing and twist.

A *motion* is a turn of one bone about one of its own axes, from the rest pose: a swing about an axis across the bone, or a twist
about the bone, its Y. Its value is the angle. Blender's drivers know the same angles ("Swing and Y Twist"): for a swing by θ
about the axis (x, 0, z) it reads 2·asin(x·sin(θ/2)) on X and 2·asin(z·sin(θ/2)) on Z, whatever the twist; so

    θ = 2·asin(x·sin(X/2) + z·sin(Z/2))

rises with the angle from -180° to 180° without a jump, past every right angle, and is 0 for a swing about the axis across.
"""

import json
import math
import re
from dataclasses import dataclass

from mathutils import Quaternion, Vector

from ...errors import SinewError
from ...measure import joint_regions
from ...reach import bone_limits
from ...scene import bone_geometry

AXES = {"X": Vector((1.0, 0.0, 0.0)), "Y": Vector((0.0, 1.0, 0.0)), "Z": Vector((0.0, 0.0, 1.0))}
BEND = "bend"
# where neither the bone's limits nor the person say how far
HINGE_DEGREES, SWING_DEGREES, TWIST_DEGREES = 150.0, 90.0, 60.0
FARTHEST_DEGREES = 175.0
# an axis of the muscles' moments as near as this to one of the bone's own means that one
SNAP_DEGREES = 20.0
_LEAST_DEGREES = 1.0
_RANGE = re.compile(r"(?:([XYZ])\s+)?(-?\d+(?:\.\d*)?)\s*\.\.\s*(-?\d+(?:\.\d*)?)(?:\s+|$)", re.IGNORECASE)


@dataclass(frozen=True)
class Motion:
    """A turn of a bone about one of its own axes.

    axis: "X", "Y", "Z" or "bend", the axis of the muscles' moments. along: unit, in the bone's rest axes; Y, or across it.
    low, high: how far, radians; rest, 0, is one of them or between them.
    """

    bone: str
    axis: str
    along: tuple[float, float, float]
    low: float
    high: float

    @property
    def is_twist(self) -> bool:
        return self.axis == "Y"

    def label(self, value: float) -> str:
        """How a key at this value is named."""
        return f"{self.bone} {self.axis if self.axis != BEND else ''}{math.degrees(value):+.5g}"


def rotation_of(turns: list[tuple[Motion, float]]) -> Quaternion:
    """The rotation of a bone that turns about several of its axes at once, such that each angle is read back as it was."""
    swing, twist = Vector(), 0.0
    for motion, value in turns:
        if motion.is_twist:
            twist += value
        else:
            swing += Vector(motion.along) * math.sin(0.5 * value)
    rest = math.sqrt(max(1.0 - swing.length_squared, 0.0))
    return Quaternion((rest, *swing)) @ Quaternion(AXES["Y"], twist)


def text_of(turns: list[tuple[Motion, float]]) -> str:
    """Turns as JSON, to be kept in a file: the bone, the name and direction of its axis, and the angle of each."""
    return json.dumps([(motion.bone, motion.axis, motion.along, value) for motion, value in turns])


def turns_in(text: str) -> list[tuple[Motion, float]]:
    """The turns in a text of `text_of`; their motions go no farther than they do."""
    return [
        (Motion(bone, axis, tuple(along), min(value, 0.0), max(value, 0.0)), value)
        for bone, axis, along, value in json.loads(text)
    ]


def motions_of(rig, joint: joint_regions.Joint, told: str, twists: bool) -> list[Motion]:
    """The motions of a joint: those that the person `told` (see `parse`), else what its bone's locks and limits leave of a
    bend about the muscles' axis (a hinge), or of swings about X and Z and a twist.
    """
    bend_axis, along = _bending_axis(rig, joint)
    if told:
        return [
            Motion(joint.bone, axis, tuple(AXES[axis]), math.radians(low), math.radians(high))
            if axis
            else _bend(joint.bone, bend_axis, along, math.radians(low), math.radians(high))
            for axis, low, high in parse(told)
        ]
    own = bone_limits.joint_of(rig.pose.bones[joint.bone])
    limits = [(own.lower[place], own.upper[place]) for place in range(3)]
    if joint.bends_one_way and not any(_is_limited(limits[place]) for place in (0, 2)):
        found = [_bend(joint.bone, bend_axis, along, 0.0, math.radians(HINGE_DEGREES))]
        twists = twists and _is_limited(limits[1])  # a knee does not twist; what does has limits that say so
    else:
        found = [_within(joint.bone, axis, limits["XYZ".index(axis)], SWING_DEGREES) for axis in "XZ"]
    if twists:
        found.append(_within(joint.bone, "Y", limits[1], TWIST_DEGREES))
    return [motion for motion in found if motion.high - motion.low >= math.radians(_LEAST_DEGREES)]


def parse(told: str) -> list[tuple[str, float, float]]:
    """Axis ("X", "Y", "Z", or "" for the bending axis), from and to in degrees, of each range in a text.

    Such a text is "0..150" or "X -20..150 Y -80..80". Raises SinewError where it is none.
    """
    ranges, place = [], 0
    text = told.strip()
    while place < len(text):
        found = _RANGE.match(text, place)
        if found is None:
            raise SinewError(
                f"'{told}' is no range of angles: write '0..150', or 'X -20..150 Y -80..80' for a bone's own axes"
            )
        axis, low, high = (found[1] or "").upper(), float(found[2]), float(found[3])
        if not -FARTHEST_DEGREES <= low <= 0.0 <= high <= FARTHEST_DEGREES or low == high:
            raise SinewError(
                f"'{found[0].strip()}' does not go from 0, the rest pose, to {FARTHEST_DEGREES:.0f} degrees or less"
            )
        ranges.append((axis, low, high))
        place = found.end()
    axes = [axis for axis, _, _ in ranges]
    if len(set(axes)) < len(axes) or ("" in axes and {"X", "Z"} & set(axes)):
        raise SinewError(f"'{told}' names an axis twice: the bending axis goes with Y alone")
    return ranges


def _bending_axis(rig, joint: joint_regions.Joint) -> tuple[str, Vector]:
    """Name and direction of the axis, across the bone, that muscles bend it about; one of the bone's own where that is near."""
    along = rig.data.bones[joint.bone].matrix_local.to_3x3().inverted() @ joint.axis
    along.y = 0.0
    if along.length < 1e-3:
        return "X", AXES["X"]
    along.normalize()
    for axis in "XZ":
        own = AXES[axis]
        if abs(along.dot(own)) > math.cos(math.radians(SNAP_DEGREES)):
            return axis, own if along.dot(own) > 0.0 else -own
    return BEND, along


def _bend(bone: str, axis: str, along: Vector, low: float, high: float) -> Motion:
    """A bend from low to high about a direction; about the bone's own axis, as a person turns it, where it is along that."""
    if axis == BEND or along.dot(AXES[axis]) > 0.0:
        return Motion(bone, axis, tuple(along), low, high)
    return Motion(bone, axis, tuple(AXES[axis]), -high, -low)


def _is_limited(limits: tuple[float, float]) -> bool:
    return limits[0] > -math.pi or limits[1] < math.pi


def _within(bone: str, axis: str, limits: tuple[float, float], degrees: float) -> Motion:
    """The motion about a bone's own axis, each way as far as its limit says, else by `degrees`; rest is always part of it."""
    farthest, unlimited = math.radians(FARTHEST_DEGREES), math.radians(degrees)
    low = min(max(limits[0], -farthest), 0.0) if limits[0] > -math.pi else -unlimited
    high = max(min(limits[1], farthest), 0.0) if limits[1] < math.pi else unlimited
    return Motion(bone, axis, tuple(AXES[axis]), low, high)


def named_bones(rig, names: str) -> list[str]:
    """The bones in a text of names with commas between. Raises SinewError for one that can't turn against a parent."""
    found = [name.strip() for name in names.split(",") if name.strip()]
    for name in found:
        if not bone_geometry.has_bone(rig, name):
            raise SinewError(f"{rig.name} has no bone '{name}': name bones of it, with commas between")
        if rig.data.bones[name].parent is None:
            raise SinewError(f"'{name}' has no parent, so there is no joint at its head: name another bone")
    return list(dict.fromkeys(found))
