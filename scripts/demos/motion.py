"""The demo's motion: elbows, knees, and what brings them before the camera, within 48 frames, by anatomical angles.

Degrees are of flexion, 0 being a straight or hanging limb. Which way a joint flexes, and how far it is flexed in the
rest pose, follows from where the bones lie at rest, so nothing depends on bone rolls.
"""

import math
from dataclasses import dataclass

import bpy
from mathutils import Matrix, Vector

FRAME_START, FRAME_END, PICTURE_FRAME = 1, 48, 24
SIDEWAYS, DOWN = Vector((1, 0, 0)), Vector((0, 0, -1))

# frame: {joint: degrees}; a joint that a pose leaves out is as in the rest pose. Of two joints of one bone, the one
# nearer to the body comes first.
ARMS = {
    f"{joint}.{side}": degrees
    for side in "LR"
    for joint, degrees in (("shoulder", 86), ("outward01", 30), ("outward02", 45), ("elbow", 118))
}
KEY_POSES = {
    FRAME_START: {},
    PICTURE_FRAME: ARMS | {"hip.L": 62, "knee.L": 98},
    36: ARMS | {"hip.R": 20, "knee.R": 95},
    FRAME_END: {},
}


# these muscles tense in the pictured pose, as they do in a person who flexes; the others only follow the bones
TENSED = ("Biceps brachii", "Brachialis", "Deltoid", "Brachioradialis", "Biceps femoris", "Gastrocnemius", "Soleus")


@dataclass(frozen=True)
class Hinge:
    """A joint that flexes about one axis of the rest pose."""

    bone: str
    axis: Vector
    rest_angle: float  # radians

    def turn(self, angle: float) -> Matrix:
        """The rotation, in the armature's space, that brings the joint from the rest pose to an angle in radians."""
        return Matrix.Rotation(angle - self.rest_angle, 3, self.axis)


def hinge(rig, joint: str) -> Hinge:
    """The hinge of a joint of KEY_POSES, such as `elbow.L`, of a MakeHuman rig."""
    kind, side = joint.split(".")
    outside = 1.0 if side == "L" else -1.0

    def head(name: str) -> Vector:
        return rig.data.bones[f"{name}.{side}"].head_local.copy()

    upper_arm, upper_leg = head("lowerarm01") - head("upperarm01"), head("lowerleg01") - head("upperleg01")
    match kind:
        case "shoulder":
            return _hinge(f"upperarm01.{side}", DOWN, upper_arm, Vector((0, -outside, 0)))
        case "outward01" | "outward02":
            return Hinge(f"upperarm{kind[-2:]}.{side}", -outside * upper_arm.normalized(), 0.0)
        case "elbow":
            lower_arm = head("wrist") - head("lowerarm01")
            return _hinge(f"lowerarm01.{side}", upper_arm, lower_arm, upper_arm.cross(lower_arm))
        case "hip":
            return _hinge(f"upperleg01.{side}", DOWN, upper_leg, -SIDEWAYS)
        case "forearm_twist" | "wrist_twist":
            bone = "lowerarm02" if kind == "forearm_twist" else "wrist"
            return Hinge(f"{bone}.{side}", (head("wrist") - head("lowerarm01")).normalized(), 0.0)
        case "knee":
            lower_leg = head("foot") - head("lowerleg01")
            return _hinge(f"lowerleg01.{side}", upper_leg, lower_leg, SIDEWAYS - SIDEWAYS.project(upper_leg))
    raise KeyError(f"the demo knows no joint {joint}")


def _hinge(bone: str, upper: Vector, lower: Vector, axis: Vector) -> Hinge:
    """The hinge between two rest directions; both are seen along the axis to measure the rest angle."""
    axis = axis.normalized()
    upper, lower = upper - upper.project(axis), lower - lower.project(axis)
    return Hinge(bone, axis, math.atan2(upper.cross(lower).dot(axis), upper.dot(lower)))


def animate(rig) -> None:
    """Keys the motion on the rig; Blender's own easing lies between the keys."""
    scene = bpy.context.scene
    scene.frame_start, scene.frame_end = FRAME_START, FRAME_END
    moved = {hinge(rig, joint).bone for pose in KEY_POSES.values() for joint in pose}
    for frame, pose in KEY_POSES.items():
        turns = dict.fromkeys(moved, Matrix.Identity(3))
        for joint, degrees in pose.items():
            found = hinge(rig, joint)
            turns[found.bone] = turns[found.bone] @ found.turn(math.radians(degrees))
        for name, turn in turns.items():
            bone = rig.pose.bones[name]
            own = bone.bone.matrix_local.to_3x3()
            bone.rotation_mode = "QUATERNION"
            bone.rotation_quaternion = (own.inverted() @ turn @ own).to_quaternion()
            bone.keyframe_insert("rotation_quaternion", frame=frame)


def tense(muscles) -> None:
    """Keys the tension of the muscles that do the work: from 0 at rest to 1 in the pictured pose, and back."""
    for muscle in muscles:
        if muscle.name.startswith(TENSED):
            for frame, tension in ((FRAME_START, 0.0), (PICTURE_FRAME, 1.0), (FRAME_END, 0.0)):
                muscle.sinew.tissue.tension = tension
                muscle.sinew.tissue.keyframe_insert("tension", frame=frame)
