"""The demo's motion: elbows and knees, and other joints that bring them in view of the camera, over 48 frames.

Angles are anatomical: degrees of flexion, with 0 for a straight or hanging limb. The direction of flexion, and the flexion
in the rest pose, follow from the positions of the bones at rest, so nothing depends on bone rolls.
"""

import math
from dataclasses import dataclass

import bpy
from mathutils import Matrix, Vector

FRAME_START, FRAME_END, PICTURE_FRAME = 1, 48, 24
SIDEWAYS, DOWN = Vector((1, 0, 0)), Vector((0, 0, -1))

# frame: {joint: degrees}. A joint that a pose does not name is at rest. If two joints belong to one bone, the one nearer to
# the body comes first.
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


# muscles that tense in the pose of the picture, as in a person who flexes; the others only follow the bones
TENSED = ("Biceps brachii", "Brachialis", "Deltoid", "Brachioradialis", "Biceps femoris", "Gastrocnemius", "Soleus")


@dataclass(frozen=True)
class Hinge:
    """A joint that flexes about one axis of the rest pose."""

    bone: str
    axis: Vector
    rest_angle: float  # radians

    def turn(self, angle: float) -> Matrix:
        """The rotation in armature space from the rest pose to an angle in radians."""
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
    raise KeyError(f"The demo has no joint {joint}")


def _hinge(bone: str, upper: Vector, lower: Vector, axis: Vector) -> Hinge:
    """The hinge between two rest directions. The rest angle is measured in the plane perpendicular to the axis."""
    axis = axis.normalized()
    upper, lower = upper - upper.project(axis), lower - lower.project(axis)
    return Hinge(bone, axis, math.atan2(upper.cross(lower).dot(axis), upper.dot(lower)))


def animate(rig) -> None:
    """Keys the motion on the rig, with Blender's default interpolation between the keys."""
    scene = bpy.context.scene
    scene.frame_start, scene.frame_end = FRAME_START, FRAME_END
    moved = {hinge(rig, joint).bone for pose in KEY_POSES.values() for joint in pose}
    for frame, pose in KEY_POSES.items():
        rotations = dict.fromkeys(moved, Matrix.Identity(3))
        for joint, degrees in pose.items():
            joint_hinge = hinge(rig, joint)
            rotations[joint_hinge.bone] = rotations[joint_hinge.bone] @ joint_hinge.turn(math.radians(degrees))
        for name, rotation in rotations.items():
            bone = rig.pose.bones[name]
            rest = bone.bone.matrix_local.to_3x3()
            bone.rotation_mode = "QUATERNION"
            bone.rotation_quaternion = (rest.inverted() @ rotation @ rest).to_quaternion()
            bone.keyframe_insert("rotation_quaternion", frame=frame)


def tense(muscles) -> None:
    """Keys the tension of the active muscles: from 0 at rest to 1 in the pose of the picture, and back."""
    for muscle in muscles:
        if muscle.name.startswith(TENSED):
            for frame, tension in ((FRAME_START, 0.0), (PICTURE_FRAME, 1.0), (FRAME_END, 0.0)):
                muscle.sinew.tissue.tension = tension
                muscle.sinew.tissue.keyframe_insert("tension", frame=frame)
