# SPDX-License-Identifier: GPL-3.0-or-later
"""Which of a rig's bones is the upper arm: by name where the rig's kind is known, else by shape, else as told.

What comes out is a guess with every bone named, which a person can correct segment by segment.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

from bpy.types import Object

from ....errors import SinewError
from . import topology
from .naming import NEXT_ROLE, ROLES, SCHEMES, SIDED_ROLES, SIDES, Scheme, in_words, places, sided

# By fewer limbs than that, names alone are a coincidence ("head", "pelvis"); the shape decides.
FEWEST_LIMB_SEGMENTS = 5
_LIMBS = tuple((role, side) for role in ("upper_arm", "forearm", "thigh", "shin") for side in SIDES)

Place = tuple[str, str]


@dataclass(frozen=True)
class Recognised:
    """The bones of each (role, side) that was found, from the body outward.

    `ends`: bones whose heads, averaged, end a segment. `edges`: a hand's two edge bones, by side. `expected`: the bone
    that the rig's kind has for a place, to name in an error.
    """

    label: str
    chains: Mapping[Place, tuple[str, ...]]
    ends: Mapping[Place, tuple[str, ...]] = field(default_factory=dict)
    edges: Mapping[str, tuple[str, str]] = field(default_factory=dict)
    expected: Mapping[Place, str] = field(default_factory=dict)


def recognise(rig: Object, corrections: Mapping[Place, str] | None = None) -> Recognised:
    """The rig's bones by role, with what a person corrected: (role, side) to the segment's first bone, "" for none.

    Raises SinewError where the object is no armature, nothing looks like limbs, or a correction names no bone or role.
    """
    if rig is None or rig.type != "ARMATURE":
        what = "nothing" if rig is None else f"'{rig.name}' ({rig.type.lower()})"
        raise SinewError(f"An armature is needed to find arms and legs, not {what}: select one, or its mesh")
    found = _by_names(rig) or _by_shape(rig)
    found = _corrected(rig, found or Recognised("by hand", {}), corrections or {})
    if not found.chains:
        known = ", ".join(scheme.label for scheme in SCHEMES)
        raise SinewError(
            f"'{rig.name}' isn't a rig that Sinew knows (it knows: {known}), and it has no two legs that mirror each "
            "other: name its bones in the table Bones of this operator, or use Add Automatic Muscles"
        )
    return found


def _by_names(rig: Object) -> Recognised | None:
    names = {}
    for bone in rig.data.bones:
        names.setdefault(_plain(bone.name), bone.name)
    guesses = [_matched(scheme, names) for scheme in SCHEMES]
    best = max(guesses, key=lambda guess: len(guess.chains))
    return best if sum(limb in best.chains for limb in _LIMBS) >= FEWEST_LIMB_SEGMENTS else None


def _by_shape(rig: Object) -> Recognised | None:
    chains = topology.chains_of(rig)
    return Recognised("a rig recognised by its shape", chains) if chains else None


def _plain(name: str) -> str:
    return name.rpartition(":")[2].lower()


def _matched(scheme: Scheme, names: Mapping[str, str]) -> Recognised:
    def real(role: str, side: str, table: Mapping[str, tuple[str, ...]]) -> tuple[str, ...]:
        wanted = (_plain(sided(scheme, name, side)) for name in table.get(role, ()))
        return tuple(names[name] for name in wanted if name in names)

    chains, ends, expected = {}, {}, {}
    for role, side in places():
        if role not in scheme.chains:
            continue
        needed = [name for name in scheme.chains[role] if not name.endswith("?")]
        lacking = [name for name in (sided(scheme, each, side) for each in needed) if _plain(name) not in names]
        if lacking:
            expected[role, side] = lacking[0]
            continue
        chains[role, side] = real(role, side, scheme.chains)
        ends[role, side] = real(role, side, scheme.ends)
    edges = {side: tuple(names.get(_plain(sided(scheme, edge, side)), "") for edge in scheme.edges) for side in SIDES}
    return Recognised(scheme.label, chains, ends, edges, expected)


def _corrected(rig: Object, found: Recognised, corrections: Mapping[Place, str]) -> Recognised:
    chains = dict(found.chains)
    changed = {}
    for (role, side), bone in corrections.items():
        _check_correction(rig, role, side, bone)
        if chains.get((role, side), ("",))[0] != bone:
            changed[role, side] = bone
    for place in changed:
        chains.pop(place, None)
    taken = set(changed.values())
    chains = {place: tuple(bone for bone in bones if bone not in taken) for place, bones in chains.items()}
    for place, bone in changed.items():
        if bone:
            chains[place] = (bone,)
    for place in changed:
        if place in chains:
            chains[place] = _down_to_next(rig, place, chains)
    ends = {place: bones for place, bones in found.ends.items() if place not in changed}
    return replace(found, chains={place: bones for place, bones in chains.items() if bones}, ends=ends)


def _check_correction(rig: Object, role: str, side: str, bone: str) -> None:
    if role not in ROLES or side not in (SIDES if role in SIDED_ROLES else ("",)):
        raise SinewError(f"Bones: there is no segment '{in_words(role, side)}'; the segments are {', '.join(ROLES)}")
    if bone and bone not in rig.data.bones:
        raise SinewError(f"Bones: the {in_words(role, side)} is said to be '{bone}', but '{rig.name}' has no such bone")


def _down_to_next(rig: Object, place: Place, chains: Mapping[Place, tuple[str, ...]]) -> tuple[str, ...]:
    """The bones between a segment's first bone and the next segment's: split bones belong to the segment above."""
    role, side = place
    first, following = chains[place][0], chains.get((NEXT_ROLE.get(role, ""), side), ())
    if not following:
        return (first,)
    between, bone = [], rig.data.bones[following[0]].parent
    while bone is not None and bone.name != first:
        between.append(bone.name)
        bone = bone.parent
    return (first, *reversed(between)) if bone is not None else (first,)
