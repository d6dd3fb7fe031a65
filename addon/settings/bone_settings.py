# SPDX-License-Identifier: GPL-3.0-or-later
"""`pose_bone.sinew`: the settings of a single bone, for its skin, for the joint at its head and for a reach."""

import bpy
from bpy.props import FloatProperty, PointerProperty
from bpy.types import PropertyGroup

from ..scene import skin_regions, stored_settings
from . import old_names
from .updates import OVERRIDABLE, bone_setting_changed

STORED = (*skin_regions.OF_BONE, *skin_regions.OF_GROWTH)  # in musculature files, and copied from bone to bone


def _factor(name: str, limits: dict):
    parameter = skin_regions.parameter_of(name)
    return FloatProperty(
        name=parameter.label,
        description=f"{parameter.description}. This factor multiplies the value of the mesh and the painted factor",
        min=0.0,
        default=1.0,
        update=bone_setting_changed,
        override=OVERRIDABLE,
        **limits,
    )


def _strength(name: str, description: str):
    return FloatProperty(
        name=name,
        description=f"{description}. 1: fully. 0: not at all",
        min=0.0,
        max=1.0,
        default=1.0,
        subtype="FACTOR",
        update=bone_setting_changed,
        override=OVERRIDABLE,
    )


class SinewBoneSettings(PropertyGroup):
    """The settings of a bone."""

    anchor_stiffness: _factor("anchor_stiffness", {"soft_max": 5.0})
    edge_stiffness: _factor("edge_stiffness", {"soft_max": 5.0})
    slack: _factor("slack", {"soft_max": 5.0})
    relaxation: _factor("relaxation", {"max": 1.0, "subtype": "FACTOR"})
    muscle_influence: _factor("muscle_influence", {"soft_max": 3.0})
    fat_sliding: _factor("fat_sliding", {"soft_max": 1.0})
    keep_volume: _strength("Keep Volume", "How strictly the skin around the joint at the bone's head keeps its volume")
    crease: _strength("Crease", "How strictly the skin on both sides of the joint at the bone's head meets in a plane")
    contact: _strength("Skin Contact", "How strictly the skin of the bone is kept from passing through other skin")
    fat_thickness: FloatProperty(
        name="Fat Thickness",
        description="Factor on the thickness of a grown skin over the tissues of the bone. Grow Skin Again shows it",
        default=1.0,
        min=0.0,
        max=100.0,
        soft_max=5.0,
        override=OVERRIDABLE,
        options=set(),
    )
    eagerness: FloatProperty(
        name="Eagerness",
        description="How much the joint prefers to rotate in a reach. 0.1 is reluctant, 2.5 is eager",
        default=1.0,
        min=0.1,
        max=2.5,
        subtype="FACTOR",
        override=OVERRIDABLE,
        options=set(),
    )


old_names.add_to(SinewBoneSettings, old_names.OF_BONES, "pose_bone.sinew")


def register():
    bpy.utils.register_class(SinewBoneSettings)
    bpy.types.PoseBone.sinew = PointerProperty(type=SinewBoneSettings, name="Sinew", override=OVERRIDABLE)


def unregister():
    del bpy.types.PoseBone.sinew
    bpy.utils.unregister_class(SinewBoneSettings)


def prepare(rig):
    """Creates the settings of all bones of a rig, with default values.

    Blender 5.2 loses the settings that a shot overrides on a bone if the library's file has no settings for that bone.
    """
    if rig.library is None:
        for bone in rig.pose.bones:
            bone.sinew  # noqa: B018  reading creates them


def nondefault(rig) -> dict[str, dict[str, float]]:
    """The settings of a rig's bones that are not 1, by bone and name."""
    settings_of = {bone.name: stored_settings.bone_of(bone) for bone in rig.pose.bones}
    values_of = {
        bone: {name: getattr(settings, name) for name in STORED}
        for bone, settings in settings_of.items()
        if settings is not None
    }
    other = {bone: {name: value for name, value in values.items() if value != 1.0} for bone, values in values_of.items()}
    return {bone: values for bone, values in other.items() if values}


def reset(rig):
    """Sets the settings of a rig's bones to 1."""
    for bone, settings in nondefault(rig).items():
        for name in settings:
            setattr(rig.pose.bones[bone].sinew, name, 1.0)


def copy(source, target):
    """Copies the settings of a pose bone to another."""
    for name in STORED:
        setattr(target.sinew, name, getattr(source.sinew, name))
