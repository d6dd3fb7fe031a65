# SPDX-License-Identifier: GPL-3.0-or-later
"""The characters of the file: rigs with their tissues, via points and bound skins.

The index of all characters is cached, and read again if the file has other objects, if their order has changed, or if a
name no longer leads to its object. If Empties point to each other, it is also read again when a user count has changed: an
Empty that the user deletes is then unlinked but stays in the file.
"""

import bpy
import numpy as np

from ..errors import SinewError
from . import armature_modifier, character_index, stored_settings, tissue_empty
from .character_index import Character, CharacterIndex, Key

_index: CharacterIndex | None = None


def forget():
    """Drops the cached index."""
    global _index
    _index = None


def is_stale(is_unedited: bool = False) -> bool:
    """Whether the cached index may be out of date. is_unedited: no edit was reported, so user counts need no check."""
    if _index is None or not np.array_equal(_index.uids, character_index.read_of_all_objects("session_uid")):
        return True
    if _index.user_counts is None or is_unedited:
        return False
    return not np.array_equal(_index.user_counts, character_index.read_of_all_objects("users"))


def current(is_unedited: bool = False) -> CharacterIndex:
    """The index of the file in its current state. is_unedited: as for `is_stale`."""
    global _index
    if _index is None or is_stale(is_unedited):
        _index = character_index.read()
    return _index


def cached() -> CharacterIndex | None:
    """The index as it was last read, which may be out of date, or None."""
    return _index


def in_file() -> tuple[Character, ...]:
    """All characters: the rigs that have tissues or bound skins."""
    return current().characters


def is_any_in_file() -> bool:
    """Whether the file has a character, or a bound mesh that follows no armature any more."""
    index = current()
    return bool(index.characters or index.orphans)


def character_of(rig) -> Character | None:
    """The character of a rig, or None if it has neither tissues nor bound skins."""
    key = Key.of(rig)
    return next((character for character in in_file() if character.rig == key), None)


def last_character_of(rig) -> Character | None:
    """As `character_of`, from the index of the last frame. For panels, which are drawn often: every edit is a frame."""
    index = _index or current()
    key = Key.of(rig)
    return next((character for character in index.characters if character.rig == key), None)


def tissues_of(rig) -> list:
    """The Empties of a rig's tissues, sorted by name. Searches the whole file."""
    return sorted(
        (
            candidate
            for candidate in bpy.data.objects
            if candidate.parent == rig and tissue_empty.is_tissue(candidate) and tissue_empty.is_used(candidate)
        ),
        key=lambda empty: empty.name,
    )


def vias_of(rig) -> list:
    """The Empties of the via points of a rig's muscles, sorted by name."""
    character = character_of(rig)
    vias = [key.find() for key in character.vias] if character else []
    if None in vias:
        forget()  # one was renamed
        return vias_of(rig)
    return vias


def skins_of(rig) -> list:
    """The meshes that follow a rig, bound or not, without the rig's shaded muscles. Searches the whole file."""
    settings = stored_settings.rig_of(rig)
    shaded = settings.shaded if settings is not None else None
    return [
        candidate
        for candidate in bpy.data.objects
        if candidate.type == "MESH" and candidate != shaded and rig_or_none(candidate) == rig
    ]


def skins_of_mesh(mesh) -> list:
    """The objects that use a mesh."""
    return [candidate for candidate in bpy.data.objects if candidate.data == mesh]


def rig_or_none(mesh_object):
    """The armature of a mesh, or None."""
    try:
        return armature_modifier.rig_of(mesh_object)
    except SinewError:
        return None  # most meshes of a file follow no armature; that is not an error here
