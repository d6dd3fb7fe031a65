# SPDX-License-Identifier: GPL-3.0-or-later
"""`sinew.range_of_motion` adds a test action: each joint rotates to the ends of its range, one after the other."""

import bpy
from bpy.props import BoolProperty, FloatProperty, IntProperty
from bpy.types import Operator
from mathutils import Quaternion

from ..bake.scratch.joint_turns import JointTurn
from ..errors import SinewError
from ..live import session
from ..scene import characters
from ..scene.linked_data import writable
from ..skin.main_skin import main_skin_of
from .angle_table import turns_of
from .base import SinewOperator, rig_of_context

ACTION = "Sinew Range of Motion"


class SINEW_OT_range_of_motion(SinewOperator, Operator):
    """Add an action that rotates each joint that muscles cross to the ends of its range, to see how the skin follows"""

    bl_idname, bl_label = "sinew.range_of_motion", "Range of Motion"
    needs_tissues = True

    frames: IntProperty(
        name="Frames", description="Frames from the rest pose to the end of a range", default=8, min=1, soft_max=50
    )
    fraction: FloatProperty(
        name="Fraction",
        description="Part of each range that is used. 1: up to the limits of the joint",
        min=0.05,
        max=1.0,
        default=0.7,
        subtype="FACTOR",
    )
    twists: BoolProperty(name="Twist", description="Also twist each joint", default=True)
    set_range: BoolProperty(
        name="Set Frame Range", description="Set the scene's frame range to that of the action", default=True
    )

    def run(self, context):
        rig = writable(rig_of_context(context))
        if rig.data.library:
            raise SinewError(f"{rig.data.name} is linked from another file. Make a library override of it first")
        skin = main_skin_of(rig) or next(iter(characters.skins_of(rig)), None)
        if skin is None:
            raise SinewError(f"{rig.name} has no mesh, so its joints are not known. Parent one to it, or grow a skin")
        context.view_layer.update()
        if session.cached_rig(rig) is None:
            raise SinewError(f"{rig.name} is not in this scene or is in Edit Mode. Show it and leave Edit Mode")
        turns = [turn for turn in turns_of(rig, [skin], None) if self.twists or not turn.is_twist]
        if not turns:
            raise SinewError(f"{rig.name} has no joint that a muscle crosses. Add muscles between bones first")
        kept = _take_action(rig)
        last = self._key(rig, in_order(turns))
        if self.set_range:
            context.scene.frame_start, context.scene.frame_end = 1, last
        context.scene.frame_set(1)
        joints = len({turn.bone for turn in turns})
        before = f". The action before, {kept}, is still in the file" if kept else ""
        return f"{joints} joints rotate in {last} frames{before}"

    def _key(self, rig, steps: list[list[JointTurn]]) -> int:
        """Keys the turns, those of a step at the same time. Returns the last frame."""
        frame = 1
        for turns in steps:
            for turn in turns:
                _key_turn(rig, turn, 0.0, frame)
            for end in ("high", "low"):
                if all(getattr(turn, end) == 0.0 for turn in turns):
                    continue
                for back in (False, True):
                    frame += self.frames
                    for turn in turns:
                        _key_turn(rig, turn, 0.0 if back else self.fraction * getattr(turn, end), frame)
        return frame


def in_order(turns: list[JointTurn]) -> list[list[JointTurn]]:
    """The turns that happen at the same time: those of the left and the right side."""
    steps: dict[tuple[str, str], list[JointTurn]] = {}
    for turn in turns:
        steps.setdefault((bpy.utils.flip_name(turn.bone) if _is_right(turn.bone) else turn.bone, turn.axis), []).append(turn)
    return list(steps.values())


def _is_right(bone: str) -> bool:
    """Whether a bone is the right one of a pair. The left of a pair comes first in the alphabet, in every naming."""
    other = bpy.utils.flip_name(bone)
    return other != bone and other < bone


def _key_turn(rig, turn: JointTurn, angle: float, frame: int):
    bone = rig.pose.bones[turn.bone]
    rotation = Quaternion(turn.direction, angle)
    if bone.rotation_mode == "QUATERNION":
        bone.rotation_quaternion, path = rotation, "rotation_quaternion"
    elif bone.rotation_mode == "AXIS_ANGLE":
        axis, turned = rotation.to_axis_angle()
        bone.rotation_axis_angle, path = (turned, *axis), "rotation_axis_angle"
    else:
        bone.rotation_euler, path = rotation.to_euler(bone.rotation_mode), "rotation_euler"
    bone.keyframe_insert(path, frame=frame)


def _take_action(rig) -> str:
    """Gives the rig a new action. Returns the name of the one before, which is kept in the file, or an empty text."""
    animation = rig.animation_data or rig.animation_data_create()
    before = animation.action
    if before and before.name.startswith(ACTION) and before.users == 1:
        bpy.data.actions.remove(before)
        before = None
    if before:
        before.use_fake_user = True
    animation.action = bpy.data.actions.new(ACTION)
    return before.name if before else ""
