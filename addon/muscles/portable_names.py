# SPDX-License-Identifier: GPL-3.0-or-later
"""Names of tissues that are the same in every file, without the numbers that Blender adds to make names unique.

Object names are unique in a file, so the tissues of a second character get numbers (".001"). A tissue keeps the name that it
was made with in `tissue.name_in_files`, until the user renames it. In one rig, no two tissues have the same portable name.
"""

import re
from collections.abc import Iterable
from dataclasses import replace

import bpy

from ..scene import characters, tissue_empty

# Blender's names have at most 63 bytes. The rest leaves room for a side (".L") or a number (".001").
LONGEST_NAME_BYTES = 58
_NUMBER = re.compile(r"\.\d{3,}$")


def of_rig(rig) -> dict[str, bpy.types.Object]:
    """The Empties of a rig's tissues by portable name. Searches the whole file."""
    empties = characters.tissues_of(rig)
    wanted = {empty: _wanted(empty) for empty in empties}
    # of duplicates, the one whose object has the wanted name keeps it, else the first
    empties.sort(key=lambda empty: (empty.name != wanted[empty], empty.name))
    named: dict[str, bpy.types.Object] = {}
    duplicates = []
    for empty in empties:
        if named.setdefault(wanted[empty], empty) != empty:
            duplicates.append(empty)
    for empty in duplicates:
        named[_free(empty.name, named)] = empty
    return named


def find(rig, name: str):
    """The rig's tissue with this portable name, else with this object name, or None."""
    named = bpy.data.objects.get(name)
    is_own = named is not None and named.parent == rig and tissue_empty.is_tissue(named) and tissue_empty.is_used(named)
    if is_own and _wanted(named) == name:
        return named
    return of_rig(rig).get(name) or (named if is_own else None)


def of_tissues(rig, empties: Iterable) -> list[str]:
    """The portable names of tissues of a rig."""
    names = {empty: name for name, empty in of_rig(rig).items()}
    return [names[empty] for empty in empties]


def portable_name(empty) -> str:
    """The portable name of one tissue. Searches the whole file: for several, use `of_tissues`."""
    return of_tissues(empty.parent, [empty])[0]


def rename(empty, name: str):
    """Renames a tissue. Blender may add a number to the name of its object."""
    empty.name = name
    empty.sinew.tissue.name_in_files = name


def with_portable_names(shape: tissue_empty.TissueShape, named: dict) -> tissue_empty.TissueShape:
    """A tissue as `tissue_empty.read` gives it, with portable names of itself and of the spheres that it wraps around.

    named: the tissues of its rig (`of_rig`).
    """
    names = {empty.name: name for name, empty in named.items()}
    return replace(shape, name=names[shape.name], wraps=tuple(names[wrap] for wrap in shape.wraps))


def with_object_names(shape: tissue_empty.TissueShape, named: dict) -> tissue_empty.TissueShape:
    """The tissue as `tissue_empty.write` takes it: the spheres that it wraps around by the names of their objects."""
    return replace(shape, wraps=tuple(named[wrap].name if wrap in named else wrap for wrap in shape.wraps))


def without_number(name: str) -> str:
    """A name without the number (".001") that Blender adds to make it unique."""
    return _NUMBER.sub("", name)


def _wanted(empty) -> str:
    """The portable name of a tissue, unless another one of its rig has it, too."""
    stored, stem = empty.sinew.tissue.name_in_files, without_number(empty.name)
    if stored and without_number(stored) == stem:
        return stored
    holder = bpy.data.objects.get(stem)
    is_of_another_rig = holder is not None and holder.parent != empty.parent
    return stem if is_of_another_rig else empty.name


def _free(name: str, taken) -> str:
    """The name, or the next name with a number, that is not taken."""
    stem, number = without_number(name), 1
    while name in taken:
        name, number = f"{stem}.{number:03d}", number + 1
    return name


def without_side(name: str) -> str:
    """A portable name without the side at its end: "Biceps.L" is "Biceps"."""
    return name[:-2] if name.endswith((".L", ".R")) else name
