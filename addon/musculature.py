# SPDX-License-Identifier: GPL-3.0-or-later
"""Adding tissues to a rig and taking them away again."""

import bpy

from . import roster, tissue_io
from .errors import SinewError

_COLLECTION_MARK = "sinew_tissues"


def add(rig, shapes: list) -> list:
    """New Empties for tissues, in the rig's own collection of muscles; a tissue of the same name is replaced.

    Raises SinewError for a muscle that goes round a sphere which is neither there nor among them; then nothing has changed.
    """
    present = {empty.name: empty for empty in roster.tissues_of(rig)}
    names = {*present, *(shape.name for shape in shapes)}
    for shape in shapes:
        missing = [wrap for wrap in shape.wraps if wrap not in names]
        if missing:
            raise SinewError(f"{shape.name} goes round {missing[0]}, which {rig.name} has not: add that sphere, too")
    collection = _collection_of(rig)
    replaced = {shape.name for shape in shapes} & present.keys()
    # a pointer to a sphere is lost with it, and belongs to the one that takes its place
    bereft = {
        name: [wrap.sphere.name for wrap in empty.sinew.wraps if wrap.sphere]
        for name, empty in present.items()
        if name not in replaced and any(wrap.sphere and wrap.sphere.name in replaced for wrap in empty.sinew.wraps)
    }
    vias = tissue_io.vias_by_muscle(filter(tissue_io.is_via, bpy.data.objects))
    for name in replaced:
        empty = present.pop(name)
        tissue_io.remove(empty, vias.get(empty.name_full, []))
    empties = [tissue_io.create(rig, shape, collection) for shape in shapes]
    named = present | {shape.name: empty for shape, empty in zip(shapes, empties)}
    wraps = bereft | {shape.name: shape.wraps for shape in shapes if shape.wraps}
    for name, spheres in wraps.items():
        tissue_io.write_wraps(named[name], [named[sphere] for sphere in spheres if sphere in named])
    roster.forget()
    return empties


def remove_all(rig) -> int:
    """Removes all tissues of a rig with their via points, and their collection; returns how many tissues there were."""
    empties = roster.tissues_of(rig)
    vias = [found for found in bpy.data.objects if found.parent == rig and tissue_io.is_via(found)]
    collections = {collection for empty in (*empties, *vias) for collection in empty.users_collection}
    for empty in (*empties, *vias):
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
