# SPDX-License-Identifier: GPL-3.0-or-later
"""Adding tissues to a rig and taking them away again."""

import bpy

from ..scene import characters

_COLLECTION_MARK = "sinew_tissues"


def collection_of(rig):
    """The rig's own collection of tissues; made where it has none."""
    for empty in characters.tissues_of(rig):
        for collection in empty.users_collection:
            if collection.get(_COLLECTION_MARK):
                return collection
    collection = bpy.data.collections.new(f"{rig.name} Muscles")
    collection[_COLLECTION_MARK] = True
    parent = next(iter(rig.users_collection), bpy.context.scene.collection)
    parent.children.link(collection)
    return collection
