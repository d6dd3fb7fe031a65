# SPDX-License-Identifier: GPL-3.0-or-later
"""The export copy of a character: its armature and meshes once more, in a collection of their own, without anything of Sinew's.

The character itself is left alone, so nothing has to be put back: removing the collection is enough. The copies play the same
actions; what was aimed at the armature itself (constraints, drivers) is aimed at its copy.
"""

import bpy

from ..display import edge_stretch_colours
from ..scene import armature_modifier, characters, correction_modifier, live_switch, painted_data, stored_settings
from ..settings import object_settings

# on each copy, the name of its original's data; what a person adds to the collection is not taken away with them
_MARK = "sinew_export_copy"


def find(rig):
    """The collection of a rig's export copy, or None."""
    settings = stored_settings.rig_of(rig)
    found = settings.export_copy if settings is not None else None
    return found if found is not None and any(map(is_copy, found.objects)) else None


def is_copy(candidate) -> bool:
    """Whether an object belongs to an export copy."""
    return _MARK in candidate


def rig_in(collection):
    """The armature of an export copy, or None where a person deleted it."""
    return next((found for found in collection.objects if is_copy(found) and found.type == "ARMATURE"), None)


def skins_in(collection) -> list:
    """The meshes of an export copy."""
    return [found for found in collection.objects if is_copy(found) and found.type == "MESH"]


def make(rig, skins: list, scene):
    """Copies a rig and skins of it into a new collection of the scene; returns it, the armature and the meshes."""
    collection = bpy.data.collections.new(f"{rig.name} Export")
    scene.collection.children.link(collection)
    rig.sinew.rig.export_copy = collection
    rig_copy = _copy(rig, collection)
    for bone in rig_copy.pose.bones:
        if bone.is_property_set("sinew"):
            object_settings.clear(bone)
        for constraint in bone.constraints:
            _aim(constraint, rig, rig_copy)
    for constraint in rig_copy.constraints:
        _aim(constraint, rig, rig_copy)
    skin_copies = [_copy_skin(skin, rig, rig_copy, collection) for skin in skins]
    for found, original in zip((rig_copy, *skin_copies), (rig, *skins), strict=True):
        data = found.data.shape_keys if found.type == "MESH" else found.data
        for owner in (found, data):
            _aim_drivers(owner, {rig: rig_copy, rig.data: rig_copy.data, original: found})
    characters.forget()
    return collection, rig_copy, skin_copies


def name(collection, rig, skins: list):
    """Names an export copy after its character, once an earlier one has left these names free."""
    collection.name = f"{rig.name} Export"
    of = {rig.data.name: rig} | {skin.data.name: skin for skin in skins}
    for found in filter(is_copy, collection.objects):
        original = of.get(found[_MARK])
        if original:
            found.name = found.data.name = f"{original.name} Export"
            own, theirs = (owner.animation_data.action if owner.animation_data else None for owner in (found, original))
            if own and own != theirs:
                own.name = f"{theirs.name if theirs else found.name} Export"


def remove(rig):
    """Takes a rig's export copy away, with its data and the actions that nothing else plays."""
    settings = stored_settings.rig_of(rig)
    collection = settings.export_copy if settings is not None else None
    if collection is None:
        return
    for found in [found for found in collection.objects if is_copy(found)]:
        remove_object(found)
    if not collection.objects and not collection.children:
        bpy.data.collections.remove(collection)
    settings.export_copy = None
    characters.forget()


def release(rig):
    """Leaves a rig's export copy to the person, without a trace of Sinew's."""
    settings = stored_settings.rig_of(rig)
    collection = settings.export_copy if settings is not None else None
    if collection is None:
        return
    for found in filter(is_copy, collection.objects):
        del found[_MARK]
    settings.export_copy = None


def remove_object(found):
    """Removes one copy with its data and its actions, where nothing else uses them."""
    data, kind = found.data, found.type
    owners = [found, data, data.shape_keys if kind == "MESH" else None]
    actions = {owner.animation_data.action for owner in owners if owner is not None and owner.animation_data}
    bpy.data.objects.remove(found)
    if data.users == 0:
        (bpy.data.meshes if kind == "MESH" else bpy.data.armatures).remove(data)
    for action in actions:
        if action is not None and action.users == 0:
            bpy.data.actions.remove(action)


def _copy(original, collection):
    copy = original.copy()
    object_settings.clear(copy)  # before anyone sees it: a second skin of the same rig
    copy.data = original.data.copy()
    copy.name = copy.data.name = f"{original.name} Export"
    copy[_MARK] = original.data.name
    collection.objects.link(copy)
    copy.hide_viewport = copy.hide_render = False
    copy.hide_set(False)
    return copy


def _copy_skin(skin, rig, rig_copy, collection):
    copy = _copy(skin, collection)
    correction_modifier.remove_correction(copy)
    cache = live_switch.cache_modifier_of(skin)
    if cache:
        copy.modifiers.remove(copy.modifiers[cache.name])  # it would overwrite what bones do
    painted_data.remove_all(copy)
    edge_stretch_colours.remove(copy.data)
    for modifier in armature_modifier.armature_modifiers(copy):
        modifier.object = rig_copy
        modifier.use_deform_preserve_volume = False  # engines skin linearly
        modifier.show_viewport = modifier.show_render = True
    if copy.parent == rig:
        inverse = copy.matrix_parent_inverse.copy()
        copy.parent = rig_copy
        copy.matrix_parent_inverse = inverse
    keys = copy.data.shape_keys
    for baked in stored_settings.baked_keys_of(skin) if keys else ():
        key = keys.key_blocks.get(baked.name)
        if key:
            key.mute = baked.muted_by_sinew
    return copy


def _aim(constraint, rig, rig_copy):
    """Aims a constraint at the copy that was aimed at the rig."""
    for name in ("target", "pole_target", "space_object"):
        if getattr(constraint, name, None) == rig:
            setattr(constraint, name, rig_copy)
    for target in getattr(constraint, "targets", ()):
        if target.target == rig:
            target.target = rig_copy


def _aim_drivers(owner, copies: dict):
    animation = owner.animation_data if owner is not None else None
    for curve in animation.drivers if animation else ():
        for variable in curve.driver.variables:
            for target in variable.targets:
                if target.id in copies:
                    target.id = copies[target.id]
