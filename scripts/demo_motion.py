"""The demo's motion: elbows, knees and a hip flex and stretch within 48 frames, by anatomical angles.

An angle of 0 is a straight limb. Which way a joint flexes, and how far it is flexed in the rest pose, follows from
where the bones lie at rest, so nothing depends on bone rolls.
"""

import math
from dataclasses import dataclass

import bpy
from mathutils import Matrix, Vector

FRAME_START, FRAME_END, PICTURE_FRAME = 1, 48, 24
SIDEWAYS, DOWN = Vector((1, 0, 0)), Vector((0, 0, -1))

# joint: ((frame, degrees of flexion; None: as in the rest pose), ...)
MOTION = {
    "elbow.L": ((1, None), (24, 118), (34, 118), (48, None)),
    "elbow.R": ((1, None), (24, 118), (34, 118), (48, None)),
    "hip.L": ((1, None), (24, 62), (44, None)),
    "knee.L": ((1, None), (24, 98), (44, None)),
    "knee.R": ((1, None), (24, None), (38, 95), (48, None)),
}


@dataclass(frozen=True)
class Hinge:
    """A joint that flexes about one axis of the rest pose."""

    bone: str
    axis: Vector
    rest_angle: float  # radians

    def turn_to(self, rig, angle: float) -> None:
        """Flexes the joint to an angle in radians."""
        bone = rig.pose.bones[self.bone]
        own = bone.bone.matrix_local.to_3x3()
        turn = Matrix.Rotation(angle - self.rest_angle, 3, self.axis)
        bone.rotation_mode = "QUATERNION"
        bone.rotation_quaternion = (own.inverted() @ turn @ own).to_quaternion()


def hinge(rig, joint: str) -> Hinge:
    """The hinge of `elbow`, `knee` or `hip`, with `.L` or `.R`, of a MakeHuman rig."""
    kind, side = joint.split(".")

    def head(name: str) -> Vector:
        return rig.data.bones[f"{name}.{side}"].head_local.copy()

    if kind == "elbow":
        upper, lower = head("lowerarm01") - head("upperarm01"), head("wrist") - head("lowerarm01")
        return _hinge(f"lowerarm01.{side}", upper, lower, upper.cross(lower))
    if kind == "knee":
        upper, lower = head("lowerleg01") - head("upperleg01"), head("foot") - head("lowerleg01")
        return _hinge(f"lowerleg01.{side}", upper, lower, SIDEWAYS - SIDEWAYS.project(upper))
    return _hinge(f"upperleg01.{side}", DOWN, head("lowerleg01") - head("upperleg01"), -SIDEWAYS)


def _hinge(bone: str, upper: Vector, lower: Vector, axis: Vector) -> Hinge:
    """The hinge between two rest directions; both are seen along the axis to measure the rest angle."""
    axis = axis.normalized()
    upper, lower = upper - upper.project(axis), lower - lower.project(axis)
    return Hinge(bone, axis, math.atan2(upper.cross(lower).dot(axis), upper.dot(lower)))


def animate(rig) -> None:
    """Keys the motion on the rig; Blender's own easing lies between the keys."""
    scene = bpy.context.scene
    scene.frame_start, scene.frame_end = FRAME_START, FRAME_END
    for joint, keys in MOTION.items():
        found = hinge(rig, joint)
        for frame, degrees in keys:
            found.turn_to(rig, found.rest_angle if degrees is None else math.radians(degrees))
            rig.pose.bones[found.bone].keyframe_insert("rotation_quaternion", frame=frame)
