# SPDX-License-Identifier: GPL-3.0-or-later
"""`object.sinew.goal`: the settings of an Empty that is the goal of a reach."""

import bpy
from bpy.props import BoolProperty, EnumProperty, FloatProperty, IntProperty, PointerProperty, StringProperty
from bpy.types import PropertyGroup

from .updates import OVERRIDABLE

AXES = tuple((axis, axis, f"The bone's {axis} axis") for axis in ("X", "Y", "Z", "-X", "-Y", "-Z"))


def _is_armature(_goal, candidate) -> bool:
    return candidate.type == "ARMATURE"


def _weight(name: str, description: str, default: float):
    return FloatProperty(
        name=name, description=description, default=default, min=0.0, soft_max=1.0, max=1000.0, override=OVERRIDABLE
    )


class SinewGoalSettings(PropertyGroup):
    """The settings of a goal."""

    rig: PointerProperty(
        name="Armature",
        description="The armature whose bone reaches for this Empty",
        type=bpy.types.Object,
        poll=_is_armature,
        override=OVERRIDABLE,
    )
    bone: StringProperty(name="Bone", description="The bone that reaches for this Empty", override=OVERRIDABLE)
    at_tail: BoolProperty(
        name="Tail",
        description="The tail of the bone reaches for the Empty. Off: its head",
        default=True,
        override=OVERRIDABLE,
        options=set(),
    )
    chain_length: IntProperty(
        name="Chain Length",
        description="Number of bones that take part, from this bone upwards. 0: all bones up to the pelvis",
        min=0,
        soft_max=20,
        override=OVERRIDABLE,
        options=set(),
    )
    position_weight: _weight("Position", "Weight of the distance between the bone's end and the Empty", 1.0)
    orientation_weight: _weight("Orientation", "Weight of the angle between the axes of the bone and of the Empty", 0.0)
    look_at_weight: _weight("Look At", "Weight of the angle between the bone's axis and the direction to the Empty", 0.0)
    look_axis: EnumProperty(
        name="Axis",
        description="The axis of the bone that points at the Empty",
        items=AXES,
        default="Y",
        override=OVERRIDABLE,
        options=set(),
    )


CLASSES = (SinewGoalSettings,)
