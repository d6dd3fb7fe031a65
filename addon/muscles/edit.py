# SPDX-License-Identifier: GPL-3.0-or-later
"""Adding tissues to a rig, changing them and removing them."""

import bpy

from ..display import views, visibility
from ..errors import SinewError
from ..scene import characters, tissue_collection, tissue_empty
from . import portable_names


def add(rig, shapes: list) -> list:
    """New Empties for tissues, in the rig's collection of tissues. They replace tissues of the same portable names.

    Raises SinewError for a muscle that wraps around a sphere that neither the rig nor `shapes` has. In that case nothing is
    changed.
    """
    remove_deleted(rig)
    collection = tissue_collection.collection_of(rig)
    present = portable_names.of_rig(rig)
    name_of = {empty: name for name, empty in present.items()}
    names = {shape.name for shape in shapes}
    for shape in shapes:
        missing = [wrap for wrap in shape.wraps if wrap not in names and wrap not in present]
        if missing:
            raise SinewError(
                f"{shape.name} wraps around sphere '{missing[0]}', which {rig.name} does not have. Add the sphere first"
            )
    replaced = names & present.keys()
    # Replacing a sphere clears the pointers to it. They are set to the new sphere below.
    lost_wraps = {
        name: [name_of[wrap.sphere] for wrap in empty.sinew.tissue.wraps if wrap.sphere in name_of]
        for name, empty in present.items()
        if name not in replaced and any(name_of.get(wrap.sphere) in replaced for wrap in empty.sinew.tissue.wraps)
    }
    vias = tissue_empty.vias_by_muscle(filter(tissue_empty.is_via, bpy.data.objects))
    for name in replaced:
        empty = present.pop(name)
        tissue_empty.remove(empty, vias.get(empty.name_full, []))
    empties = [tissue_empty.create(rig, shape, collection) for shape in shapes]
    tissues = present | {shape.name: empty for shape, empty in zip(shapes, empties)}
    wraps = lost_wraps | {shape.name: shape.wraps for shape in shapes if shape.wraps}
    for name, spheres in wraps.items():
        tissue_empty.write_wraps(tissues[name], [tissues[sphere] for sphere in spheres])
    vias_of_created = tissue_empty.vias_by_muscle(filter(tissue_empty.is_via, bpy.data.objects))
    created_vias = [via for empty in empties for via in vias_of_created.get(empty.name_full, ())]
    visibility.apply(rig, [*empties, *created_vias], bpy.context.view_layer)
    characters.forget()
    return empties


def add_or_update(rig, shapes: list) -> list:
    """The Empties of these tissues. Tissues of the same portable names are changed, the others are added.

    An existing Empty stays the same object and keeps its keys, children and constraints. Raises SinewError as `add` does.
    """
    remove_deleted(rig)
    named = portable_names.of_rig(rig)
    present = [(shape, named.get(shape.name)) for shape in shapes]
    created = iter(add(rig, [shape for shape, empty in present if empty is None]))
    # once for all tissues, because each search visits all objects of the file
    named = portable_names.of_rig(rig)
    vias = tissue_empty.vias_by_muscle(filter(tissue_empty.is_via, bpy.data.objects))
    for shape, empty in present:
        if empty:
            empty.sinew.tissue.kind = shape.kind
            empty.sinew.tissue.origin_bone = shape.origin_bone
            tissue_empty.write(empty, portable_names.with_object_names(shape, named), vias.get(empty.name_full, []))
    return [empty or next(created) for _shape, empty in present]


def remove(empties: list):
    """Removes tissues with their via points."""
    for empty in empties:
        tissue_empty.remove(empty)
    characters.forget()


def remove_deleted(rig):
    """Removes Empties that the user deleted but that other Empties still point to, and the via points of such muscles.

    Blender keeps such an Empty in the file. It would block its name for a new tissue and be found under that name.
    """
    deleted = [
        empty
        for empty in bpy.data.objects
        if empty.parent == rig
        and (tissue_empty.is_tissue(empty) or tissue_empty.is_via(empty))
        and not tissue_empty.is_used(empty)
    ]
    vias = [
        empty
        for empty in bpy.data.objects
        if empty.parent == rig
        and tissue_empty.is_via(empty)
        and empty not in deleted
        and empty.sinew.tissue.muscle in deleted
    ]
    for empty in (*vias, *deleted):
        bpy.data.objects.remove(empty)
    if deleted:
        characters.forget()


def remove_all(rig) -> int:
    """Removes all tissues of a rig with their via points and their collection. Returns the number of removed tissues."""
    views.remove(rig)
    remove_deleted(rig)
    empties = characters.tissues_of(rig)
    vias = [empty for empty in bpy.data.objects if empty.parent == rig and tissue_empty.is_via(empty)]
    for empty in (*empties, *vias):
        tissue_empty.discard(empty)
    tissue_collection.remove_empty()
    characters.forget()
    return len(empties)
