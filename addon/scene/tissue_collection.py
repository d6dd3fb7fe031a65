# SPDX-License-Identifier: GPL-3.0-or-later
"""The Blender collection that holds the tissues of a rig."""

import bpy

from . import characters

_MARK = "sinew_tissues"  # custom property of a collection that Sinew made


def is_ours(collection) -> bool:
    """Whether Sinew made this collection."""
    return bool(collection.get(_MARK))


def collection_of(rig):
    """The rig's collection of tissues. It is made if there is none."""
    for empty in characters.tissues_of(rig):
        for collection in empty.users_collection:
            if is_ours(collection):
                return collection
    collection = bpy.data.collections.new(f"{rig.name} Muscles")
    collection[_MARK] = True
    holders_of(rig)[0].children.link(collection)
    return collection


def holders_of(rig) -> list:
    """The collections of a rig that can hold what is made for it, or that of the scene.

    Blender lets nobody link anything to a collection that is linked or overrides a linked one.
    """
    can_hold = [holder for holder in rig.users_collection if holder.library is None and holder.override_library is None]
    return can_hold or [bpy.context.scene.collection]


def remove_empty():
    """Removes the collections that Sinew made for tissues and that are empty: the user may have deleted the tissues."""
    for collection in list(bpy.data.collections):
        is_local = collection.library is None and collection.override_library is None
        if is_local and is_ours(collection) and not collection.all_objects and not collection.children:
            bpy.data.collections.remove(collection)
