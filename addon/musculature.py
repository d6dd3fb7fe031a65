# SPDX-License-Identifier: GPL-3.0-or-later
"""Adding tissues to a rig and taking them away again."""

import re

import bpy

from . import roster, tissue_io
from .layers import shaded, visibility

_COLLECTION_MARK = "sinew_tissues"
_NUMBER = re.compile(r"\.\d{3,}$")


def add(rig, shapes: list) -> list:
    """New Empties for tissues, in the rig's own collection of muscles; a tissue of the same name is replaced."""
    collection = collection_of(rig)
    for shape in shapes:
        present = find(rig, shape.name)
        if present:
            bpy.data.objects.remove(present)
    empties = [tissue_io.create(rig, shape, collection) for shape in shapes]
    visibility.apply(rig, empties, bpy.context.view_layer)
    roster.forget()
    return empties


def put(rig, shapes: list) -> list:
    """The Empties of tissues with these places and settings: the rig's own of those names, else new ones.

    An Empty that is there stays the same object, with its keys and whatever a person hung on it.
    """
    present = [(shape, find(rig, shape.name)) for shape in shapes]
    created = iter(add(rig, [shape for shape, empty in present if empty is None]))
    for shape, empty in present:
        if empty:
            empty.sinew.kind = shape.kind
            empty.sinew.origin_bone = shape.origin_bone
            tissue_io.write(empty, shape)
    return [empty or next(created) for _shape, empty in present]


def remove(empties: list):
    """Removes some tissues."""
    for empty in empties:
        bpy.data.objects.remove(empty)
    roster.forget()


def find(rig, name: str):
    """The rig's tissue of this name, or None.

    Two characters in one file can't have objects of one name: Blender adds a number to the second, which still counts.
    """
    own = bpy.data.objects.get(name)
    if own is None:
        return None
    if own.parent == rig and tissue_io.is_tissue(own):
        return own
    return next((empty for empty in roster.tissues_of(rig) if portable_name(empty) == name), None)


def portable_name(empty) -> str:
    """A tissue's name without the number that Blender added because another character's tissue has that name."""
    stem = _NUMBER.sub("", empty.name)
    other = bpy.data.objects.get(stem)
    is_others = other is not None and other.parent != empty.parent
    return stem if is_others else empty.name


def remove_all(rig) -> int:
    """Removes all tissues of a rig and their collection; returns how many there were."""
    shaded.remove(rig)
    empties = roster.tissues_of(rig)
    collections = {collection for empty in empties for collection in empty.users_collection}
    for empty in empties:
        bpy.data.objects.remove(empty)
    for collection in collections:
        if collection.get(_COLLECTION_MARK) and not collection.all_objects and not collection.children:
            bpy.data.collections.remove(collection)
    roster.forget()
    return len(empties)


def collection_of(rig):
    """The rig's own collection of tissues; made where it has none."""
    for empty in roster.tissues_of(rig):
        for collection in empty.users_collection:
            if collection.get(_COLLECTION_MARK):
                return collection
    collection = bpy.data.collections.new(f"{rig.name} Muscles")
    collection[_COLLECTION_MARK] = True
    parent = next(iter(rig.users_collection), bpy.context.scene.collection)
    parent.children.link(collection)
    return collection
