# SPDX-License-Identifier: GPL-3.0-or-later
"""`object.sinew`: the group that holds the settings of an object by owner, and the version that wrote them."""

import bpy
from bpy.props import BoolProperty, IntProperty, PointerProperty
from bpy.types import PropertyGroup

from ..display import timing_overlay
from ..scene import stored_settings
from . import goal_settings, growth_settings, old_names, rig_settings, skin_settings, tissue_settings
from .updates import OVERRIDABLE

# 1: all settings of Sinew 0.1 in one group, which had no version. 2: a group for each owner (Sinew 0.2)
VERSION = 2


class SinewObjectSettings(PropertyGroup):
    """The settings of an object. Reading one of the four groups creates it: see `scene/stored_settings`."""

    version: IntProperty(
        name="Version",
        description="Version of the settings' layout, written when the file is saved or migrated. 0: not saved yet",
        options={"HIDDEN"},
    )
    tissue: PointerProperty(type=tissue_settings.SinewTissueSettings, name="Tissue", override=OVERRIDABLE)
    skin: PointerProperty(type=skin_settings.SinewSkinSettings, name="Skin", override=OVERRIDABLE)
    rig: PointerProperty(type=rig_settings.SinewRigSettings, name="Armature", override=OVERRIDABLE)
    goal: PointerProperty(type=goal_settings.SinewGoalSettings, name="Goal", override=OVERRIDABLE)


old_names.add_to(
    SinewObjectSettings,
    old_names.OF_OBJECTS,
    "object.sinew",
    {
        "tissue": tissue_settings.SinewTissueSettings,
        "skin": skin_settings.SinewSkinSettings,
        "rig": rig_settings.SinewRigSettings,
    },
)
old_names.add_to(skin_settings.SinewBakedKey, old_names.OF_BAKED_KEYS, "baked_key")

CLASSES = (
    *goal_settings.CLASSES,
    *growth_settings.CLASSES,
    *tissue_settings.CLASSES,
    *skin_settings.CLASSES,
    *rig_settings.CLASSES,
    SinewObjectSettings,
)


def register():
    for cls in CLASSES:
        bpy.utils.register_class(cls)
    bpy.types.Object.sinew = PointerProperty(type=SinewObjectSettings, name="Sinew", override=OVERRIDABLE)
    bpy.types.WindowManager.sinew_show_times = BoolProperty(
        name="Show Times",
        description="Show the duration of a frame over the viewport: pose, muscles, skin and total, and frames per second",
        options=set(),
        get=lambda _manager: timing_overlay.is_shown(),
        set=lambda _manager, shown: timing_overlay.show(shown),
    )


def unregister():
    del bpy.types.WindowManager.sinew_show_times
    del bpy.types.Object.sinew
    for cls in reversed(CLASSES):
        if cls.is_registered:
            bpy.utils.unregister_class(cls)


def clear(carrier):
    """Removes all settings of an object or a pose bone, without a trace."""
    carrier.property_unset("sinew")
    root = stored_settings.properties_of(carrier)
    if root is not None and "sinew" in root:
        del root["sinew"]
