# SPDX-License-Identifier: GPL-3.0-or-later
"""Adding tissues to a rig and taking them away again."""

import bpy

from . import roster, tissue_io

_COLLECTION_MARK = "sinew_tissues"


def add(rig, shapes: list) -> list:
    """New Empties for tissues, in the rig's own collection of muscles; a tissue of the same name is replaced."""
    collection = _collection_of(rig)
    present = {empty.name: empty for empty in roster.tissues_of(rig)}
    for shape in shapes:
        if shape.name in present:
            bpy.data.objects.remove(present[shape.name])
    empties = [tissue_io.create(rig, shape, collection) for shape in shapes]
    roster.forget()
    return empties


def remove_all(rig) -> int:
    """Removes all tissues of a rig and their collection; returns how many there were."""
    empties = roster.tissues_of(rig)
    collections = {collection for empty in empties for collection in empty.users_collection}
    for empty in empties:
        bpy.data.objects.remove(empty)
    for collection in collections:
        if collection.get(_COLLECTION_MARK) and not collection.all_objects and not collection.children:
            bpy.data.collections.remove(collection)
    roster.forget()
    return len(empties)


def _collection_of(rig):
    for empty in roster.tissues_of(rig):
        for collection in empty.users_collection:
            if collection.get(_COLLECTION_MARK):
                return collection
    collection = bpy.data.collections.new(f"{rig.name} Muscles")
    collection[_COLLECTION_MARK] = True
    parent = next(iter(rig.users_collection), bpy.context.scene.collection)
    parent.children.link(collection)
    return collection
