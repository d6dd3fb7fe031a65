"""Keys a walk on Rigify's metarigs and a motion on the toad and the hand.

Rotations are about the armature's axes, whatever the rolls of the bones, or about a bone's own axes ("local X").
"""

import math

import bpy
from mathutils import Matrix

FRAME_START, FRAME_END, PICTURE_FRAME = 1, 49, 16
CYCLE, STEP = 24, 3  # frames per stride, and between keys


def _stride(phase: float, swing: float, lift: float) -> tuple[float, float]:
    """Degrees of the upper bone, and degrees by which its children are lifted while it swings forward."""
    angle = 2.0 * math.pi * phase
    return swing * math.cos(angle), lift * max(0.0, math.sin(angle))


def _on_fours(phase: float, front: tuple[str, str, str], hind: tuple[str, str, str], tail: tuple[str, ...]) -> dict:
    """{bone: (axis, degrees)}. A positive angle about X swings a hanging limb backward."""
    pose = {}
    for side, offset in (("L", 0.0), ("R", 0.5)):
        swing, lift = _stride(phase + offset, 24.0, 45.0)
        pose |= {f"{bone}.{side}": ("X", angle) for bone, angle in zip(front, (swing, -lift, lift))}
        swing, lift = _stride(phase + offset + 0.25, 24.0, 40.0)
        pose |= {f"{bone}.{side}": ("X", angle) for bone, angle in zip(hind, (swing, lift, -0.8 * lift))}
    sway = math.sin(2.0 * math.pi * phase)
    return pose | {bone: ("Z", 11.0 * sway) for bone in tail}


def _cat(phase: float) -> dict[str, tuple[str, float]]:
    tail = ("tail.001", "tail.002", "tail.003", "tail.004")
    pose = _on_fours(phase, ("upper_arm", "forearm", "hand"), ("thigh", "shin", "foot"), tail)
    sway = math.sin(2.0 * math.pi * phase)
    return pose | {"spine.002": ("Z", 4.0 * sway), "spine.005": ("X", 6.0 * abs(sway))}


def _dog(phase: float) -> dict[str, tuple[str, float]]:
    tail = ("spine.003", "spine.002", "spine.001", "spine")
    return _on_fours(phase, ("front_thigh", "front_shin", "front_foot"), ("thigh", "shin", "foot"), tail)


def _horse(phase: float) -> dict[str, tuple[str, float]]:
    tail = ("tail.001", "tail.002", "tail.003")
    return _on_fours(phase, ("upper_arm", "forearm", "forefoot"), ("thigh", "lower_leg", "hind_foot"), tail)


def _toad(phase: float) -> dict[str, tuple[str, float]]:
    """A crawl: the limbs swing about the vertical axis."""
    pose = {}
    for side, outside, offset in (("L", 1.0, 0.0), ("R", -1.0, 0.5)):
        swing, _lift = _stride(phase + offset, 22.0, 0.0)
        pose |= {f"upper_arm.{side}": ("Z", outside * swing), f"forearm.{side}": ("Z", -0.6 * outside * swing)}
        swing, _lift = _stride(phase + offset + 0.5, 18.0, 0.0)
        pose |= {f"thigh.{side}": ("Z", outside * swing), f"shin.{side}": ("Z", -outside * swing)}
    return pose | {"spine.003": ("Z", 6.0 * math.sin(2.0 * math.pi * phase))}


def _hand(phase: float) -> dict[str, tuple[str, float]]:
    """The fingers close one after another, about the bones' own X axes."""
    pose = {}
    for side in ("L", "R"):
        for index, finger in enumerate(("f_index", "f_middle", "f_ring", "f_pinky")):
            closed = 0.5 - 0.5 * math.cos(2.0 * math.pi * (phase - 0.06 * index))
            for bone, degrees in (("01", 60.0), ("02", 80.0), ("03", 45.0)):
                pose[f"{finger}.{bone}.{side}"] = ("local X", degrees * closed)
        pose[f"thumb.02.{side}"] = ("local X", 25.0 * (0.5 - 0.5 * math.cos(2.0 * math.pi * phase)))
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


POSES = {"cat": _cat, "dog": _dog, "horse": _horse, "toad": _toad, "hand": _hand, "human": _human}


def animate(rig, animal: str) -> None:
    """Keys the walk on the rig."""
    scene = bpy.context.scene
    scene.frame_start, scene.frame_end = FRAME_START, FRAME_END
    for frame in range(FRAME_START, FRAME_END + 1, STEP):
        for name, (axis, degrees) in POSES[animal]((frame - FRAME_START) / CYCLE).items():
            bone = rig.pose.bones[name]
            rest = bone.bone.matrix_local.to_3x3()
            rotation = Matrix.Rotation(math.radians(degrees), 3, axis[-1])
            if not axis.startswith("local"):
                rotation = rest.inverted() @ rotation @ rest
            bone.rotation_mode = "QUATERNION"
            bone.rotation_quaternion = rotation.to_quaternion()
            bone.keyframe_insert("rotation_quaternion", frame=frame)
