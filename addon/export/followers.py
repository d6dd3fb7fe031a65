# SPDX-License-Identifier: GPL-3.0-or-later
"""The meshes of a character that Sinew is not bound to, such as eyes and shoes: they belong in the file, too."""

from ..scene import armature_modifier, characters
from .export_copy import is_copy


def of(rig) -> list:
    """The visible meshes that follow a rig by a modifier or as its children, without bound ones and export copies."""
    return [
        mesh
        for mesh in characters.skins_of(rig)
        if not armature_modifier.is_bound(mesh) and not is_copy(mesh) and mesh.visible_get() and mesh.data.polygons
    ]
