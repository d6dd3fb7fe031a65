# SPDX-License-Identifier: GPL-3.0-or-later
"""Who belongs to whom: the rigs of this file with their tissues and their bound skins, by name.

Names, not references: a kept reference to Blender data crashes after undo. Other objects in the file, in another order,
or a name that no longer leads to the object, make the roster stale, and the next look reads it again. So does another
count of users of an object, where Empties point to each other: one that a person deletes is then unlinked but stays.
"""

from dataclasses import dataclass

import bpy
import numpy as np

from ..errors import SinewError
from . import armature_modifier, tissue_empty


@dataclass(frozen=True)
class Key:
    """An object's name and the library it is linked from (None: this file), which is how `bpy.data` finds it."""

    name: str
    library: str | None

    @classmethod
    def of(cls, found) -> "Key":
        return cls(found.name, found.library.filepath if found.library else None)

    def find(self):
        return bpy.data.objects.get((self.name, self.library))


@dataclass(frozen=True)
class Character:
    """A rig with its tissues, in the order of their names, the skins bound to it, and the via points of its muscles."""

    rig: Key
    tissues: tuple[Key, ...]
    skins: tuple[Key, ...]
    vias: tuple[Key, ...] = ()

    @property
    def keys(self) -> tuple[Key, ...]:
        """Of all its objects."""
        return (self.rig, *self.tissues, *self.skins, *self.vias)


@dataclass(frozen=True)
class CharacterObjects:
    """The objects of a character, found for the moment: references that are not to be kept."""

    rig: bpy.types.Object
    tissues: list
    skins: list
    vias: list


@dataclass(frozen=True)
class UidIndex:
    """The session-wide identifiers of all that characters are made of, to recognise them in Blender's reports.

    bound_names: of the objects that a bind depends on, which are all but the rigs: those are posed.
    """

    objects: frozenset[int]
    armatures: frozenset[int]
    skins_of_mesh: dict[int, list[Key]]
    bound_names: frozenset[str]


@dataclass(frozen=True)
class CharacterIndex:
    """All rigs of the file that have tissues or bound skins, and what tells whether that is still so.

    orphans: the bound meshes that follow no armature any more, and why. uids: of all objects of the file, in its order.
    user_counts: likewise, where any of ours points to another. is_all_local: no object is linked or overrides one.
    """

    characters: tuple[Character, ...]
    orphans: dict[Key, str]
    watch: UidIndex
    uids: np.ndarray
    user_counts: np.ndarray | None
    is_all_local: bool
    names: list[list[str]]  # of each character's objects
    places: list[list[int]]  # and where they are among all of the file

    def members(self, are_names_known: bool) -> list[CharacterObjects] | None:
        """The objects of each character, in order; None where one was renamed since this was read.

        are_names_known: nothing but rigs can have been renamed.
        """
        objects = bpy.data.objects.values()
        found = []
        for character, names, places in zip(self.characters, self.names, self.places):
            own = [objects[place] for place in places]
            named = own[:1] if are_names_known else own
            if [one.name for one in named] != names[: len(named)]:
                return None
            skins, vias = 1 + len(character.tissues), 1 + len(character.tissues) + len(character.skins)
            found.append(CharacterObjects(own[0], own[1:skins], own[skins:vias], own[vias:]))
        return found


_roster: CharacterIndex | None = None


def forget():
    """Makes the next look read the file again."""
    global _roster
    _roster = None


def is_stale(is_unedited: bool = False) -> bool:
    """Whether what is kept may no longer be true. is_unedited: nobody can have deleted an Empty of ours."""
    if _roster is None or not np.array_equal(_roster.uids, _read_of_all("session_uid")):
        return True
    if _roster.user_counts is None or is_unedited:
        return False
    return not np.array_equal(_roster.user_counts, _read_of_all("users"))


def _read_of_all(name: str) -> np.ndarray:
    """(objects,) int32: a number of each object of the file."""
    numbers = np.empty(len(bpy.data.objects), np.int32)
    bpy.data.objects.foreach_get(name, numbers)
    return numbers


def current(is_unedited: bool = False) -> CharacterIndex:
    """The roster of the file as it is. is_unedited: as for `is_stale`."""
    global _roster
    if _roster is None or is_stale(is_unedited):
        _roster = _read()
    return _roster


def cached() -> CharacterIndex | None:
    """The roster as it was at the last look, which may no longer be true; None where it was forgotten."""
    return _roster


def in_file() -> tuple[Character, ...]:
    """All rigs of the file that have tissues or bound skins."""
    return current().characters


def _watch_of(characters: tuple[Character, ...]) -> UidIndex:
    objects, armatures, skins_of_mesh, bound_names = set(), set(), {}, set()
    for character in characters:
        rig = character.rig.find()
        objects.add(rig.session_uid)
        armatures.add(rig.data.session_uid)
        objects.update(key.find().session_uid for key in (*character.tissues, *character.vias))
        for key in character.skins:
            skin = key.find()
            objects.add(skin.session_uid)
            skins_of_mesh.setdefault(skin.data.session_uid, []).append(key)
        bound_names.update(key.name for key in character.keys[1:])
    return UidIndex(frozenset(objects), frozenset(armatures), skins_of_mesh, frozenset(bound_names))


def character_of(rig) -> Character | None:
    """The character of a rig, or None where it has neither tissues nor bound skins."""
    key = Key.of(rig)
    return next((character for character in in_file() if character.rig == key), None)


def tissues_of(rig) -> list:
    """The tissue Empties of a rig, in the order of their names, read from the file now."""
    return sorted(
        (
            found
            for found in bpy.data.objects
            if found.parent == rig and tissue_empty.is_tissue(found) and tissue_empty.is_used(found)
        ),
        key=lambda found: found.name,
    )


def vias_of(rig) -> list:
    """The Empties of the via points of a rig's muscles, in the order of their names."""
    character = character_of(rig)
    vias = [key.find() for key in character.vias] if character else []
    if None in vias:
        forget()  # renamed: the next look finds the new names
        return vias_of(rig)
    return vias


def skins_of(rig) -> list:
    """The meshes that follow a rig, bound or not, read from the file now; what shows its muscles is none of them."""
    return [
        found
        for found in bpy.data.objects
        if found.type == "MESH" and found != rig.sinew.shaded and _rig_or_none(found) == rig
    ]


def skins_of_mesh(mesh) -> list:
    """The objects that show a mesh."""
    return [found for found in bpy.data.objects if found.data == mesh]


def _rig_or_none(skin):
    try:
        return armature_modifier.rig_of(skin)
    except SinewError:
        return None  # asked of every mesh in the file: that most follow no armature is no fault


def _read() -> CharacterIndex:
    characters, orphans = _read_characters()
    place_of = {Key.of(found): place for place, found in enumerate(bpy.data.objects)}
    return CharacterIndex(
        characters=characters,
        orphans=orphans,
        watch=_watch_of(characters),
        uids=_read_of_all("session_uid"),
        user_counts=_read_of_all("users") if any(map(_points_elsewhere, bpy.data.objects)) else None,
        is_all_local=not any(found.library or found.override_library for found in bpy.data.objects),
        names=[[key.name for key in character.keys] for character in characters],
        places=[[place_of[key] for key in character.keys] for character in characters],
    )


def _read_characters() -> tuple[tuple[Character, ...], dict[Key, str]]:
    tissues: dict = {}
    vias: dict = {}
    skins: dict = {}
    orphaned: dict[Key, str] = {}
    for found in bpy.data.objects:
        if tissue_empty.is_tissue(found):
            if found.parent and found.parent.type == "ARMATURE" and tissue_empty.is_used(found):
                tissues.setdefault(Key.of(found.parent), []).append(Key.of(found))
        elif tissue_empty.is_via(found):
            if found.parent and found.parent.type == "ARMATURE" and tissue_empty.is_used(found):
                vias.setdefault(Key.of(found.parent), []).append(Key.of(found))
        elif armature_modifier.is_bound(found):
            try:
                skins.setdefault(Key.of(armature_modifier.rig_of(found)), []).append(Key.of(found))
            except SinewError as error:
                orphaned[Key.of(found)] = str(error)
    characters = tuple(
        Character(
            rig,
            tuple(sorted(tissues.get(rig, ()), key=lambda key: key.name)),
            tuple(sorted(skins.get(rig, ()), key=lambda key: key.name)),
            tuple(sorted(vias.get(rig, ()), key=lambda key: key.name)),
        )
        for rig in dict.fromkeys((*tissues, *skins))
    )
    return characters, orphaned


def _points_elsewhere(found) -> bool:
    """Whether an object is a via point or a muscle with wraps, or a tissue that is linked nowhere (yet, or any more)."""
    if tissue_empty.is_via(found):
        return True
    return tissue_empty.is_tissue(found) and (len(found.sinew.wraps) > 0 or not tissue_empty.is_used(found))
