# SPDX-License-Identifier: GPL-3.0-or-later
"""Collections that can hold new objects. Blender links nothing to one that is linked or that overrides a linked one."""

import bpy


def is_editable(collection) -> bool:
    """Whether objects can be linked to a collection."""
    return collection.library is None and collection.override_library is None


def editable_collections_of(owner) -> list:
    """The collections of an object that can hold what is made for it, or that of the scene."""
    return [holder for holder in owner.users_collection if is_editable(holder)] or [bpy.context.scene.collection]
