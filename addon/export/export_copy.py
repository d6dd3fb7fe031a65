# SPDX-License-Identifier: GPL-3.0-or-later
"""The export copy of a character: copies of its armature and meshes without Sinew, in a collection.

The character is not changed, so removing the collection is enough to undo the copy. The copies play the same actions.
Constraints and drivers that refer to the armature refer to its copy.
"""

import bpy

from ..display import edge_stretch_colours, translucent_skin
from ..scene import armature_modifier, characters, correction_modifier, live_switch, painted_data, stored_settings
from ..scene.retarget import retarget_constraint, retarget_drivers
from ..settings import object_settings

# A property of each copy that holds the name of its original's data. Objects that the user adds to the collection lack
# it and so
# are never removed.
_MARK = "sinew_export_copy"


def find(rig):
    """Returns the collection of a rig's export copy, or None."""
    settings = stored_settings.rig_of(rig)
    collection = settings.export_copy if settings is not None else None
    return collection if collection is not None and any(map(is_copy, collection.objects)) else None


def is_copy(candidate) -> bool:
    """Whether an object belongs to an export copy."""
    return _MARK in candidate


def rig_in(collection):
    """Returns the armature of an export copy, or None if the user deleted it."""
    return next((each for each in collection.objects if is_copy(each) and each.type == "ARMATURE"), None)


def skins_in(collection) -> list:
    """Returns the meshes of an export copy."""
    return [each for each in collection.objects if is_copy(each) and each.type == "MESH"]


def skins_without_copy(rig, collection) -> list[str]:
    """The names of the rig's bound meshes that its export copy lacks."""
    copied = {copy[_MARK] for copy in skins_in(collection)}
    bound = [skin for skin in characters.skins_of(rig) if armature_modifier.is_bound(skin)]
    return [skin.name for skin in bound if skin.data.name not in copied]


def make(rig, skins: list, scene):
    """Copies a rig and its skins into a new collection of the scene. Returns the collection, the armature and the meshes."""
    collection = bpy.data.collections.new(f"{rig.name} Export")
    scene.collection.children.link(collection)
    rig.sinew.rig.export_copy = collection
    rig_copy = _copy(rig, collection)
    for bone in rig_copy.pose.bones:
        if bone.is_property_set("sinew"):
            object_settings.clear(bone)
        for constraint in bone.constraints:
            retarget_constraint(constraint, rig, rig_copy)
    for constraint in rig_copy.constraints:
        retarget_constraint(constraint, rig, rig_copy)
    skin_copies = [_copy_skin(skin, rig, rig_copy, collection) for skin in skins]
    for copy, original in zip((rig_copy, *skin_copies), (rig, *skins), strict=True):
        data = copy.data.shape_keys if copy.type == "MESH" else copy.data
        for owner in (copy, data):
            retarget_drivers(owner, {rig: rig_copy, rig.data: rig_copy.data, original: copy})
    characters.forget()
    return collection, rig_copy, skin_copies


def name(collection, rig, skins: list):
    """Names an export copy after its character. Call it after an earlier copy, which has the same names, is removed."""
    collection.name = f"{rig.name} Export"
    originals = {rig.data.name: rig} | {skin.data.name: skin for skin in skins}
    for copy in filter(is_copy, collection.objects):
        original = originals.get(copy[_MARK])
        if original:
            copy.name = copy.data.name = f"{original.name} Export"
            action, theirs = (owner.animation_data.action if owner.animation_data else None for owner in (copy, original))
            if action and action != theirs:
                action.name = f"{theirs.name if theirs else copy.name} Export"


def remove(rig):
    """Removes a rig's export copy, with its data and the actions that nothing else plays."""
    settings = stored_settings.rig_of(rig)
    collection = settings.export_copy if settings is not None else None
    if collection is not None:
        remove_collection(collection)
        settings.export_copy = None


def remove_collection(collection):
    """Removes the export copy in a collection, as `remove`. The character may have been deleted."""
    for copy in [each for each in collection.objects if is_copy(each)]:
        _remove_object(copy)
    if not collection.objects and not collection.children:
        bpy.data.collections.remove(collection)
    characters.forget()


def release(rig):
    """Keeps a rig's export copy as ordinary objects, without Sinew's marks."""
    settings = stored_settings.rig_of(rig)
    collection = settings.export_copy if settings is not None else None
    if collection is None:
        return
    for copy in filter(is_copy, collection.objects):
        del copy[_MARK]
    settings.export_copy = None


def _remove_object(copy):
    """Removes one copy, with its data and its actions if nothing else uses them."""
    data, kind = copy.data, copy.type
    owners = [copy, data, data.shape_keys if kind == "MESH" else None]
    actions = {owner.animation_data.action for owner in owners if owner is not None and owner.animation_data}
    bpy.data.objects.remove(copy)
    if data.users == 0:
        (bpy.data.meshes if kind == "MESH" else bpy.data.armatures).remove(data)
    for action in actions:
        if action is not None and action.users == 0:
            bpy.data.actions.remove(action)


def _copy(original, collection):
    copy = original.copy()
    if copy.override_library:
        copy = copy.make_local(clear_liboverride=True)  # Blender allows no Edit Mode for an override
    object_settings.clear(copy)  # before it is linked: it would count as another skin of the same rig
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
    translucent_skin.remove(copy)
    cache = live_switch.cache_modifier_of(skin)
    if cache:
        copy.modifiers.remove(copy.modifiers[cache.name])  # it would overwrite the points
    painted_data.remove_all(copy)
    edge_stretch_colours.remove(copy.data)
    for modifier in armature_modifier.armature_modifiers(copy):
        modifier.object = rig_copy
        modifier.use_deform_preserve_volume = False  # engines use linear blend skinning
        modifier.show_viewport = modifier.show_render = True
    second = armature_modifier.second_of_pair(copy)
    if second:
        copy.modifiers.remove(second)  # without Preserve Volume both do the same
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
