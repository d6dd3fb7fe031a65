# SPDX-License-Identifier: GPL-3.0-or-later
"""Settings of the Empties that are goals of a reach."""

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


class SinewGoal(PropertyGroup):
    """What an Empty is the goal of."""

    rig: PointerProperty(
        name="Armature",
        description="The armature whose bone reaches for this Empty",
        type=bpy.types.Object,
        poll=_is_armature,
        override=OVERRIDABLE,
    )
    bone: StringProperty(name="Bone", description="The bone that reaches for this Empty", override=OVERRIDABLE)
    at_tail: BoolProperty(
        name="Tail", description="The bone's tail reaches for the Empty; off: its head", default=True, override=OVERRIDABLE
    )
    chain_length: IntProperty(
        name="Chain Length",
        description="How many bones take part, from this one up; 0: all up to the pelvis",
        min=0,
        soft_max=20,
        override=OVERRIDABLE,
    )
    position_weight: _weight("Position", "How much it counts that the bone's end is where the Empty is", 1.0)
    orientation_weight: _weight("Orientation", "How much it counts that the bone is turned as the Empty is", 0.0)
    look_at_weight: _weight("Look At", "How much it counts that the bone points at the Empty", 0.0)
    look_axis: EnumProperty(
        name="Axis",
        description="The axis of the bone that points at the Empty",
        items=AXES,
        default="Y",
        override=OVERRIDABLE,
    )


def register():
    bpy.utils.register_class(SinewGoal)


def unregister():
    bpy.utils.unregister_class(SinewGoal)
