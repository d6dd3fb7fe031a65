# SPDX-License-Identifier: GPL-3.0-or-later
"""Reads which objects of the file are characters: rigs with their tissues, via points and bound skins.

The index holds names instead of references, because a kept reference to Blender data crashes after undo. It also holds the
numbers by which `characters` recognises that the file has changed.
"""

from dataclasses import dataclass

import bpy
import numpy as np

from ..errors import SinewError
from . import armature_modifier, tissue_empty


@dataclass(frozen=True)
class Key:
    """The name of an object and the library that it is linked from, or None. `bpy.data` finds an object by both."""

    name: str
    library: str | None

    @classmethod
    def of(cls, linked_object) -> "Key":
        library = linked_object.library
        return cls(linked_object.name, library.filepath if library else None)

    def find(self):
        return bpy.data.objects.get((self.name, self.library))


@dataclass(frozen=True)
class Character:
    """A rig with its tissues, the skins bound to it and the via points of its muscles, each sorted by name."""

    rig: Key
    tissues: tuple[Key, ...]
    skins: tuple[Key, ...]
    vias: tuple[Key, ...] = ()

    @property
    def keys(self) -> tuple[Key, ...]:
        """The keys of all its objects, the rig first."""
        return (self.rig, *self.tissues, *self.skins, *self.vias)


@dataclass(frozen=True)
class CharacterObjects:
    """The objects of a character. These are references, which must not be kept."""

    rig: bpy.types.Object
    tissues: list
    skins: list
    vias: list


@dataclass(frozen=True)
class UidIndex:
    """Session-wide identifiers of the data of all characters, to recognise it in Blender's reports of updates.

    bound_names: the names of all objects that a bind depends on. Rigs are not among them, because posing changes them.
    skins_of_mesh: the bound skins of each mesh, sorted by name. links: what each tissue, via point and bound mesh was linked
    to when the index was read (`links_of`).
    """

    objects: frozenset[int]
    armatures: frozenset[int]
    skins_of_mesh: dict[int, list[Key]]
    bound_names: frozenset[str]
    links: dict[int, tuple]

    def is_linked_elsewhere(self, member) -> bool:
        """Whether a tissue, via point or bound mesh now belongs to another armature, or has another mesh."""
        links = self.links.get(member.session_uid)
        return links is not None and links != links_of(member)


@dataclass(frozen=True)
class CharacterIndex:
    """All characters of the file.

    orphans: the bound meshes that follow no armature any more, each with the reason.
    uids: session-wide identifiers of all objects of the file, in order. user_counts: their user counts, or None if no tissue
    or via point points to another object.
    names: the names of each character's objects. rows: their indices among all objects of the file.
    """

    characters: tuple[Character, ...]
    orphans: dict[Key, str]
    uid_index: UidIndex
    uids: np.ndarray
    user_counts: np.ndarray | None
    names: list[list[str]]
    rows: list[list[int]]

    def tissue_rows(self, rig) -> list[tuple[Key, int]]:
        """The tissues of a rig, sorted by name, each with its index among all objects of the file."""
        key = Key.of(rig)
        for character, rows in zip(self.characters, self.rows):
            if character.rig == key:
                return list(zip(character.tissues, rows[1:]))
        return []

    def objects(self, are_names_known: bool) -> list[CharacterObjects] | None:
        """The objects of each character, in order. None if one, or an orphan, was renamed since the index was read.

        are_names_known: only rigs can have been renamed, so no other names are compared.
        """
        if not are_names_known and not all(key.find() for key in self.orphans):
            return None
        all_objects = bpy.data.objects.values()
        of_characters = []
        for character, names, rows in zip(self.characters, self.names, self.rows):
            members = [all_objects[row] for row in rows]
            compared = members[:1] if are_names_known else members
            if [member.name for member in compared] != names[: len(compared)]:
                return None
            skins = 1 + len(character.tissues)
            vias = skins + len(character.skins)
            of_characters.append(CharacterObjects(members[0], members[1:skins], members[skins:vias], members[vias:]))
        return of_characters


def read() -> CharacterIndex:
    """Reads the index from the file."""
    characters, orphans = _read_characters()
    row_of = {Key.of(any_object): row for row, any_object in enumerate(bpy.data.objects)}
    return CharacterIndex(
        characters=characters,
        orphans=orphans,
        uid_index=_uid_index_of(characters, orphans),
        uids=read_of_all_objects("session_uid"),
        user_counts=read_of_all_objects("users") if any(map(_depends_on_user_counts, bpy.data.objects)) else None,
        names=[[key.name for key in character.keys] for character in characters],
        rows=[[row_of[key] for key in character.keys] for character in characters],
    )


def read_of_all_objects(name: str) -> np.ndarray:
    """(objects,) int32: an integer property of all objects of the file, in order."""
    numbers = np.empty(len(bpy.data.objects), np.int32)
    bpy.data.objects.foreach_get(name, numbers)
    return numbers


def _read_characters() -> tuple[tuple[Character, ...], dict[Key, str]]:
    tissues: dict = {}
    vias: dict = {}
    skins: dict = {}
    orphans: dict[Key, str] = {}
    for candidate in bpy.data.objects:
        if tissue_empty.is_tissue(candidate):
            if _is_used_on_a_rig(candidate):
                tissues.setdefault(Key.of(candidate.parent), []).append(Key.of(candidate))
        elif tissue_empty.is_via(candidate):
            if _is_used_on_a_rig(candidate):
                vias.setdefault(Key.of(candidate.parent), []).append(Key.of(candidate))
        elif armature_modifier.is_bound(candidate):
            try:
                skins.setdefault(Key.of(armature_modifier.rig_of(candidate)), []).append(Key.of(candidate))
            except SinewError as error:
                orphans[Key.of(candidate)] = str(error)
    characters = tuple(
        Character(
            rig,
            tuple(sorted(tissues.get(rig, ()), key=lambda key: key.name)),
            tuple(sorted(skins.get(rig, ()), key=lambda key: key.name)),
            tuple(sorted(vias.get(rig, ()), key=lambda key: key.name)),
        )
        for rig in dict.fromkeys((*tissues, *skins))
    )
    return characters, orphans


def _is_used_on_a_rig(empty) -> bool:
    return bool(empty.parent and empty.parent.type == "ARMATURE" and tissue_empty.is_used(empty))


def _uid_index_of(characters: tuple[Character, ...], orphans: dict[Key, str]) -> UidIndex:
    objects, armatures, skins_of_mesh, bound_names, links = set(), set(), {}, set(), {}
    for character in characters:
        rig = character.rig.find()
        objects.add(rig.session_uid)
        armatures.add(rig.data.session_uid)
        for key in character.keys[1:]:
            member = key.find()
            objects.add(member.session_uid)
            links[member.session_uid] = links_of(member)
            bound_names.add(key.name)
        for key in character.skins:
            skins_of_mesh.setdefault(key.find().data.session_uid, []).append(key)
    for key in orphans:
        orphan = key.find()
        objects.add(orphan.session_uid)
        links[orphan.session_uid] = links_of(orphan)
        bound_names.add(key.name)
    for keys in skins_of_mesh.values():
        keys.sort(key=lambda key: (key.name, key.library or ""))
    return UidIndex(frozenset(objects), frozenset(armatures), skins_of_mesh, frozenset(bound_names), links)


def links_of(member) -> tuple:
    """The identifiers of the data by which a tissue, via point or bound mesh belongs to a character."""
    linked = [member.parent]
    if member.type == "MESH":
        linked += [member.data, *(modifier.object for modifier in armature_modifier.armature_modifiers(member))]
    return tuple(found.session_uid if found else 0 for found in linked)


def _depends_on_user_counts(candidate) -> bool:
    """Whether an object can be deleted or restored without a change in the list of all objects.

    A deleted Empty stays in that list while another one points to it. This can happen to via points, to the spheres of
    muscles with wraps, and to tissues that are in no collection now.
    """
    if not tissue_empty.is_tissue(candidate):
        return tissue_empty.is_via(candidate)
    return len(candidate.sinew.tissue.wraps) > 0 or not tissue_empty.is_used(candidate)
