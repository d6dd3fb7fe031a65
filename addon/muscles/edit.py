# SPDX-License-Identifier: GPL-3.0-or-later
"""Adding tissues to a rig and taking them away again."""

import bpy

from ..display import shaded, visibility
from ..errors import SinewError
from ..scene import characters, tissue_empty
from . import portable_names, tissue_collection


def add(rig, shapes: list) -> list:
    """New Empties for tissues, in the rig's own collection of muscles; a tissue of the same name is replaced.

    Raises SinewError for a muscle that goes round a sphere which is neither there nor among them; then nothing has changed.
    """
    remove_deleted(rig)
    collection = tissue_collection.collection_of(rig)
    present = {portable_names.portable_name(empty): empty for empty in characters.tissues_of(rig)}
    names = {shape.name for shape in shapes}
    for shape in shapes:
        missing = [wrap for wrap in shape.wraps if wrap not in names and portable_names.find(rig, wrap) is None]
        if missing:
            raise SinewError(f"{shape.name} goes round {missing[0]}, which {rig.name} has not: add that sphere, too")
    replaced = names & present.keys()
    # a pointer to a sphere is lost with it, and belongs to the one that takes its place
    bereft = {
        empty.name: [portable_names.portable_name(wrap.sphere) for wrap in empty.sinew.wraps if wrap.sphere]
        for name, empty in present.items()
        if name not in replaced
        and any(wrap.sphere and portable_names.portable_name(wrap.sphere) in replaced for wrap in empty.sinew.wraps)
    }
    vias = tissue_empty.vias_by_muscle(filter(tissue_empty.is_via, bpy.data.objects))
    for name in replaced:
        empty = present.pop(name)
        tissue_empty.remove(empty, vias.get(empty.name_full, []))
    empties = [tissue_empty.create(rig, shape, collection) for shape in shapes]
    created = {shape.name: empty for shape, empty in zip(shapes, empties)}
    wraps = bereft | {shape.name: shape.wraps for shape in shapes if shape.wraps}
    for name, spheres in wraps.items():
        muscle = created.get(name) or bpy.data.objects[name]
        tissue_empty.write_wraps(muscle, [created.get(sphere) or portable_names.find(rig, sphere) for sphere in spheres])
    vias_of_created = tissue_empty.vias_by_muscle(filter(tissue_empty.is_via, bpy.data.objects))
    created_vias = [via for empty in empties for via in vias_of_created.get(empty.name_full, ())]
    visibility.apply(rig, [*empties, *created_vias], bpy.context.view_layer)
    characters.forget()
    return empties


def put(rig, shapes: list) -> list:
    """The Empties of tissues with these places and settings: the rig's own of those names, else new ones.

    An Empty that is there stays the same object, with its keys and whatever a person hung on it.
    """
    remove_deleted(rig)
    present = [(shape, portable_names.find(rig, shape.name)) for shape in shapes]
    created = iter(add(rig, [shape for shape, empty in present if empty is None]))
    vias = tissue_empty.vias_by_muscle(
        filter(tissue_empty.is_via, bpy.data.objects)
    )  # once: a look goes through the whole file
    for shape, empty in present:
        if empty:
            empty.sinew.kind = shape.kind
            empty.sinew.origin_bone = shape.origin_bone
            tissue_empty.write(empty, shape, vias.get(empty.name_full, []))
    return [empty or next(created) for _shape, empty in present]


def remove(empties: list):
    """Removes some tissues."""
    for empty in empties:
        tissue_empty.remove(empty)
    characters.forget()


def remove_deleted(rig):
    """Removes what a person deleted but other Empties still point to, and the via points of such muscles.

    It would keep its name from the tissue that takes its place, and be found under it.
    """
    deleted = [
        found
        for found in bpy.data.objects
        if found.parent == rig
        and (tissue_empty.is_tissue(found) or tissue_empty.is_via(found))
        and not tissue_empty.is_used(found)
    ]
    vias = [
        found
        for found in bpy.data.objects
        if found.parent == rig and tissue_empty.is_via(found) and found not in deleted and found.sinew.muscle in deleted
    ]
    for found in (*vias, *deleted):
        bpy.data.objects.remove(found)
    if deleted:
        characters.forget()


def remove_all(rig) -> int:
    """Removes all tissues of a rig with their via points, and their collection; returns how many tissues there were."""
    shaded.remove(rig)
    remove_deleted(rig)
    empties = characters.tissues_of(rig)
    vias = [found for found in bpy.data.objects if found.parent == rig and tissue_empty.is_via(found)]
    collections = {collection for empty in (*empties, *vias) for collection in empty.users_collection}
    for empty in (*empties, *vias):
        tissue_empty.discard(empty)
    for collection in collections:
        if collection.get(tissue_collection._COLLECTION_MARK) and not collection.all_objects and not collection.children:
            bpy.data.collections.remove(collection)
    characters.forget()
    return len(empties)
