# SPDX-License-Identifier: GPL-3.0-or-later
"""The collection that holds the tissues of a rig."""

import bpy

from . import characters

COLLECTION_MARK = "sinew_tissues"


def collection_of(rig):
    """The collection of a rig's tissues; a new one if the rig has none."""
    for empty in characters.tissues_of(rig):
        for collection in empty.users_collection:
            if collection.get(COLLECTION_MARK):
                return collection
    collection = bpy.data.collections.new(f"{rig.name} Muscles")
    collection[COLLECTION_MARK] = True
    parent = next(iter(rig.users_collection), bpy.context.scene.collection)
    parent.children.link(collection)
    return collection
