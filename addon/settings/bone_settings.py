# SPDX-License-Identifier: GPL-3.0-or-later
"""What a person sets on single bones, kept in Blender's own data: `pose_bone.sinew`.

These names are a stable surface, as those of `properties`.
"""

import bpy
from bpy.props import FloatProperty, PointerProperty
from bpy.types import PropertyGroup

from ..live import session
from ..scene import skin_regions
from .updates import OVERRIDABLE, setting_changed


def _changed(settings, context):
    session.forget_bone_settings(settings.id_data)
    setting_changed(settings, context)


def _factor(name: str, limits: dict):
    parameter = skin_regions.parameter_of(name)
    return FloatProperty(
        name=parameter.label,
        description=f"{parameter.description}. Multiplies what is set for the whole mesh and what is painted",
        min=0.0,
        default=1.0,
        update=_changed,
        override=OVERRIDABLE,
        **limits,
    )


def _strength(name: str, description: str):
    return FloatProperty(
        name=name,
        description=f"{description}: 1 fully, 0 not at all",
        min=0.0,
        max=1.0,
        default=1.0,
        subtype="FACTOR",
        update=_changed,
        override=OVERRIDABLE,
    )


class SinewBoneSettings(PropertyGroup):
    """Sinew's settings of one bone: of the skin that it carries, and of the joint at its head, in shape and in motion."""

    anchor_stiffness: _factor("anchor_stiffness", {"soft_max": 5.0})
    edge_stiffness: _factor("edge_stiffness", {"soft_max": 5.0})
    rest_distance: _factor("rest_distance", {"soft_max": 5.0})
    relaxation: _factor("relaxation", {"max": 1.0, "subtype": "FACTOR"})
    muscle_influence: _factor("muscle_influence", {"soft_max": 3.0})
    fat_sliding: _factor("fat_sliding", {"soft_max": 1.0})
    keep_volume: _strength("Keep Volume", "How fully the joint at the bone's head keeps the volume of its skin")
    crease: _strength("Crease", "How fully the skin on both sides of the joint at the bone's head meets in a plane")
    contact: _strength("Skin Contact", "How fully the skin of the bone keeps off other skin")
    multiplier: FloatProperty(
        name="Eagerness",
        description="How eager the joint is to turn when its bone takes part in a reach: 0.1 is lazy, 2.5 eager",
        default=1.0,
        min=0.1,
        max=2.5,
        subtype="FACTOR",
        override=OVERRIDABLE,
    )


def register():
    bpy.utils.register_class(SinewBoneSettings)
    bpy.types.PoseBone.sinew = PointerProperty(type=SinewBoneSettings, name="Sinew", override=OVERRIDABLE)


def unregister():
    del bpy.types.PoseBone.sinew
    bpy.utils.unregister_class(SinewBoneSettings)


def prepare(rig):
    """Lets each bone of a rig have its settings, none of them set.

    Blender 5.2 loses what a shot overrides on a bone whose settings are not yet there in the library's file.
    """
    if rig.library is None:
        for bone in rig.pose.bones:
            bone.sinew  # Blender makes them as they are asked for


def nondefault(rig) -> dict[str, dict[str, float]]:
    """What a rig's bones are set to, by bone and setting; what is 1 is left out."""
    bones = [bone for bone in rig.pose.bones if bone.is_property_set("sinew")]
    settings = {bone.name: {name: getattr(bone.sinew, name) for name in skin_regions.OF_BONE} for bone in bones}
    other = {bone: {name: value for name, value in own.items() if value != 1.0} for bone, own in settings.items()}
    return {bone: own for bone, own in other.items() if own}


def reset(rig):
    """Sets all settings of a rig's bones to 1."""
    for bone, settings in nondefault(rig).items():
        for name in settings:
            setattr(rig.pose.bones[bone].sinew, name, 1.0)


def copy(source, target):
    """Gives a pose bone the settings of another."""
    for name in skin_regions.OF_BONE:
        setattr(target.sinew, name, getattr(source.sinew, name))
