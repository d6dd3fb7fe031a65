"""Keys a walk on Rigify's cat and human metarigs, with rotations about the armature's axes, whatever the bone rolls."""

import math

import bpy
from mathutils import Matrix

FRAME_START, FRAME_END, PICTURE_FRAME = 1, 49, 16
CYCLE, STEP = 24, 3  # frames per stride, and between keys


def _stride(phase: float, swing: float, lift: float) -> tuple[float, float]:
    """Degrees of the upper bone, and degrees by which its children are lifted while it swings forward."""
    angle = 2.0 * math.pi * phase
    return swing * math.cos(angle), lift * max(0.0, math.sin(angle))


def _cat(phase: float) -> dict[str, tuple[str, float]]:
    """{bone: (axis, degrees)}. A positive angle about X swings a hanging limb backward."""
    pose = {}
    for side, offset in (("L", 0.0), ("R", 0.5)):
        swing, lift = _stride(phase + offset, 24.0, 45.0)
        pose |= {
            f"upper_arm.{side}": ("X", swing),
            f"forearm.{side}": ("X", -lift),
            f"hand.{side}": ("X", lift),
        }
        swing, lift = _stride(phase + offset + 0.25, 24.0, 40.0)
        pose |= {f"thigh.{side}": ("X", swing), f"shin.{side}": ("X", lift), f"foot.{side}": ("X", -0.8 * lift)}
    sway = math.sin(2.0 * math.pi * phase)
    pose |= {f"tail.00{number}": ("Z", 11.0 * sway) for number in range(1, 5)}
    pose |= {"spine.002": ("Z", 4.0 * sway), "spine.005": ("X", 6.0 * abs(sway))}
    return pose


def _human(phase: float) -> dict[str, tuple[str, float]]:
    pose = {}
    for side, offset, outside in (("L", 0.0, 1.0), ("R", 0.5, -1.0)):
        swing, lift = _stride(phase + offset, 26.0, 55.0)
        pose |= {f"thigh.{side}": ("X", swing - 4.0), f"shin.{side}": ("X", lift + 6.0)}
        pose |= {f"upper_arm.{side}": ("X", -0.8 * swing), f"forearm.{side}": ("X", -25.0 - 0.6 * abs(swing))}
        pose |= {f"shoulder.{side}": ("Y", outside * 8.0)}
    pose["spine.001"] = ("Z", 5.0 * math.sin(2.0 * math.pi * phase))
    return pose


POSES = {"cat": _cat, "human": _human}


def animate(rig, animal: str) -> None:
    """Keys the walk on the rig."""
    scene = bpy.context.scene
    scene.frame_start, scene.frame_end = FRAME_START, FRAME_END
    for frame in range(FRAME_START, FRAME_END + 1, STEP):
        for name, (axis, degrees) in POSES[animal]((frame - FRAME_START) / CYCLE).items():
            bone = rig.pose.bones[name]
            rest = bone.bone.matrix_local.to_3x3()
            rotation = Matrix.Rotation(math.radians(degrees), 3, axis)
            bone.rotation_mode = "QUATERNION"
            bone.rotation_quaternion = (rest.inverted() @ rotation @ rest).to_quaternion()
            bone.keyframe_insert("rotation_quaternion", frame=frame)
