# SPDX-License-Identifier: GPL-3.0-or-later
"""Adding tissues to a rig and taking them away again."""

import re

import bpy

from . import roster, tissue_io
from .errors import SinewError
from .layers import shaded, visibility

_COLLECTION_MARK = "sinew_tissues"
_NUMBER = re.compile(r"\.\d{3,}$")


def add(rig, shapes: list) -> list:
    """New Empties for tissues, in the rig's own collection of muscles; a tissue of the same name is replaced.

    Raises SinewError for a muscle that goes round a sphere which is neither there nor among them; then nothing has changed.
    """
    remove_deleted(rig)
    collection = collection_of(rig)
    present = {portable_name(empty): empty for empty in roster.tissues_of(rig)}
    names = {shape.name for shape in shapes}
    for shape in shapes:
        missing = [wrap for wrap in shape.wraps if wrap not in names and find(rig, wrap) is None]
        if missing:
            raise SinewError(f"{shape.name} goes round {missing[0]}, which {rig.name} has not: add that sphere, too")
    replaced = names & present.keys()
    # a pointer to a sphere is lost with it, and belongs to the one that takes its place
    bereft = {
        empty.name: [portable_name(wrap.sphere) for wrap in empty.sinew.wraps if wrap.sphere]
        for name, empty in present.items()
        if name not in replaced and any(wrap.sphere and portable_name(wrap.sphere) in replaced for wrap in empty.sinew.wraps)
    }
    vias = tissue_io.vias_by_muscle(filter(tissue_io.is_via, bpy.data.objects))
    for name in replaced:
        empty = present.pop(name)
        tissue_io.remove(empty, vias.get(empty.name_full, []))
    empties = [tissue_io.create(rig, shape, collection) for shape in shapes]
    created = {shape.name: empty for shape, empty in zip(shapes, empties)}
    wraps = bereft | {shape.name: shape.wraps for shape in shapes if shape.wraps}
    for name, spheres in wraps.items():
        muscle = created.get(name) or bpy.data.objects[name]
        tissue_io.write_wraps(muscle, [created.get(sphere) or find(rig, sphere) for sphere in spheres])
    vias_of_created = tissue_io.vias_by_muscle(filter(tissue_io.is_via, bpy.data.objects))
    created_vias = [via for empty in empties for via in vias_of_created.get(empty.name_full, ())]
    visibility.apply(rig, [*empties, *created_vias], bpy.context.view_layer)
    roster.forget()
    return empties


def put(rig, shapes: list) -> list:
    """The Empties of tissues with these places and settings: the rig's own of those names, else new ones.

    An Empty that is there stays the same object, with its keys and whatever a person hung on it.
    """
    remove_deleted(rig)
    present = [(shape, find(rig, shape.name)) for shape in shapes]
    created = iter(add(rig, [shape for shape, empty in present if empty is None]))
    vias = tissue_io.vias_by_muscle(filter(tissue_io.is_via, bpy.data.objects))  # once: a look goes through the whole file
    for shape, empty in present:
        if empty:
            empty.sinew.kind = shape.kind
            empty.sinew.origin_bone = shape.origin_bone
            tissue_io.write(empty, shape, vias.get(empty.name_full, []))
    return [empty or next(created) for _shape, empty in present]


def remove(empties: list):
    """Removes some tissues."""
    for empty in empties:
        tissue_io.remove(empty)
    roster.forget()


def remove_deleted(rig):
    """Removes what a person deleted but other Empties still point to, and the via points of such muscles.

    It would keep its name from the tissue that takes its place, and be found under it.
    """
    deleted = [
        found
        for found in bpy.data.objects
        if found.parent == rig and (tissue_io.is_tissue(found) or tissue_io.is_via(found)) and not tissue_io.is_used(found)
    ]
    vias = [
        found
        for found in bpy.data.objects
        if found.parent == rig and tissue_io.is_via(found) and found not in deleted and found.sinew.muscle in deleted
    ]
    for found in (*vias, *deleted):
        bpy.data.objects.remove(found)
    if deleted:
        roster.forget()


def find(rig, name: str):
    """The rig's tissue of this name, or None.

    Two characters in one file can't have objects of one name: Blender adds a number to the second, which still counts.
    """
    own = bpy.data.objects.get(name)
    if own is None:
        return None
    if own.parent == rig and tissue_io.is_tissue(own) and tissue_io.is_used(own):
        return own
    return next((empty for empty in roster.tissues_of(rig) if portable_name(empty) == name), None)


def portable_name(empty) -> str:
    """A tissue's name without the number that Blender added because another character's tissue has that name."""
    stem = _NUMBER.sub("", empty.name)
    other = bpy.data.objects.get(stem)
    is_others = other is not None and other.parent != empty.parent
    return stem if is_others else empty.name


def remove_all(rig) -> int:
    """Removes all tissues of a rig with their via points, and their collection; returns how many tissues there were."""
    shaded.remove(rig)
    remove_deleted(rig)
    empties = roster.tissues_of(rig)
    vias = [found for found in bpy.data.objects if found.parent == rig and tissue_io.is_via(found)]
    collections = {collection for empty in (*empties, *vias) for collection in empty.users_collection}
    for empty in (*empties, *vias):
        tissue_io.discard(empty)
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
