# SPDX-License-Identifier: GPL-3.0-or-later
"""The Blender collection that holds the tissues of a rig."""

import bpy

from . import characters
from .editable_collections import editable_collections_of, is_editable

_MARK = "sinew_tissues"  # custom property of a collection that Sinew made


def is_ours(collection) -> bool:
    """Whether Sinew made this collection."""
    return bool(collection.get(_MARK))


def collection_of(rig):
    """The rig's collection of tissues. It is made if there is none that can hold more."""
    for empty in characters.tissues_of(rig):
        for collection in empty.users_collection:
            if is_ours(collection) and is_editable(collection):
                return collection
    collection = bpy.data.collections.new(f"{rig.name} Muscles")
    collection[_MARK] = True
    editable_collections_of(rig)[0].children.link(collection)
    return collection


def remove_empty():
    """Removes the collections that Sinew made for tissues and that are empty: the user may have deleted the tissues."""
    for collection in list(bpy.data.collections):
        if is_editable(collection) and is_ours(collection) and not collection.all_objects and not collection.children:
            bpy.data.collections.remove(collection)
