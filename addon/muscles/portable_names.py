# SPDX-License-Identifier: GPL-3.0-or-later
"""Adding tissues to a rig and taking them away again."""

import re

import bpy

from ..scene import characters, tissue_empty

_NUMBER = re.compile(r"\.\d{3,}$")


def find(rig, name: str):
    """The rig's tissue of this name, or None.

    Two characters in one file can't have objects of one name: Blender adds a number to the second, which still counts.
    """
    own = bpy.data.objects.get(name)
    if own is None:
        return None
    if own.parent == rig and tissue_empty.is_tissue(own) and tissue_empty.is_used(own):
        return own
    return next((empty for empty in characters.tissues_of(rig) if portable_name(empty) == name), None)


def portable_name(empty) -> str:
    """A tissue's name without the number that Blender added because another character's tissue has that name."""
    stem = _NUMBER.sub("", empty.name)
    other = bpy.data.objects.get(stem)
    is_others = other is not None and other.parent != empty.parent
    return stem if is_others else empty.name
