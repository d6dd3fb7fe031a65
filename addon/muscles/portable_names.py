# SPDX-License-Identifier: GPL-3.0-or-later
"""Names of tissues that are the same in every file, without the numbers that Blender adds to make names unique."""

import re

import bpy

from ..scene import characters, tissue_empty

# Blender's names have at most 63 bytes. The rest leaves room for a side (".L") or a number (".001").
LONGEST_NAME_BYTES = 58
_NUMBER = re.compile(r"\.\d{3,}$")


def find(rig, name: str):
    """The rig's tissue with this name or portable name, or None.

    Object names are unique in a file. Blender adds a number to the second character's tissue of the same name.
    """
    named = bpy.data.objects.get(name)
    if named is None:
        return None
    if named.parent == rig and tissue_empty.is_tissue(named) and tissue_empty.is_used(named):
        return named
    return next((empty for empty in characters.tissues_of(rig) if portable_name(empty) == name), None)


def without_number(name: str) -> str:
    """A name without the number (".001") that Blender adds to make it unique."""
    return _NUMBER.sub("", name)


def portable_name(empty) -> str:
    """A tissue's name without the number that Blender added because another character's tissue has that name."""
    stem = without_number(empty.name)
    holder = bpy.data.objects.get(stem)
    is_of_another_rig = holder is not None and holder.parent != empty.parent
    return stem if is_of_another_rig else empty.name
