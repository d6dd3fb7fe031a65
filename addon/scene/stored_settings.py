# SPDX-License-Identifier: GPL-3.0-or-later
"""Reads the settings of objects and bones without creating settings on those that have none.

Blender creates a group of settings when a script reads its pointer. Code that looks at objects which may not belong to
Sinew uses these functions; each returns the group, or None where it does not exist. Code that knows its object, or is about
to set something, reads `object.sinew.tissue` and the like directly.
"""

import bpy

# called on the class, they skip the look-up of old names (`settings/old_names`), which would take half of the time
_is_set, _resolve = bpy.types.bpy_struct.is_property_set, bpy.types.bpy_struct.path_resolve


def tissue_of(candidate):
    """`object.sinew.tissue` of the Empty of a tissue or via point, or None."""
    return _group(candidate, "tissue")


def skin_of(candidate):
    """`object.sinew.skin` of a mesh object, or None."""
    return _group(candidate, "skin")


def rig_of(candidate):
    """`object.sinew.rig` of an armature object, or None."""
    return _group(candidate, "rig")


def goal_of(candidate):
    """`object.sinew.goal` of the Empty of a goal, or None."""
    return _group(candidate, "goal")


def rig_of_goal(candidate):
    """The armature whose bone reaches for an Empty, or None where the object is not a goal."""
    goal = goal_of(candidate)
    return goal.rig if goal is not None else None


def growth_of(candidate):
    """`object.sinew.skin.growth` of a grown skin, or None."""
    skin = skin_of(candidate)
    return skin.growth if skin is not None and skin.is_property_set("growth") else None


def worn_over_of(skin):
    """The mesh object that a skin is worn over, or None. Reading the pointer itself would create it, as an empty one."""
    settings = skin_of(skin)
    return settings.worn_over if settings is not None and settings.is_property_set("worn_over") else None


def is_grown(skin) -> bool:
    """Whether a mesh object is a grown skin."""
    growth = growth_of(skin)
    return growth is not None and growth.is_grown


def bone_of(pose_bone):
    """`pose_bone.sinew`, or None."""
    return pose_bone.sinew if pose_bone.is_property_set("sinew") else None


def baked_keys_of(skin):
    """The shape keys that Sinew baked for a mesh object: `object.sinew.skin.baked_keys`, or an empty tuple."""
    settings = skin_of(skin)
    return settings.baked_keys if settings is not None else ()


def _group(carrier, name: str):
    if not carrier.is_property_set("sinew"):
        return None
    owner = carrier.sinew
    return _resolve(owner, name) if _is_set(owner, name) else None


def properties_of(carrier):
    """The ID properties that hold the values of add-on properties: of the carrier itself, or its own group from Blender 5.0.

    None where the carrier has no such group.
    """
    return carrier.bl_system_properties_get() if hasattr(carrier, "bl_system_properties_get") else carrier
