# SPDX-License-Identifier: GPL-3.0-or-later
"""Which bones of a rig belong to which body part: by name for known kinds of rig, else by shape, corrected by the user.

The result names a bone for every part that was found, so that the user can correct each part separately.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

from bpy.types import Object

from ....errors import SinewError
from . import topology
from .body_parts import NEXT_ROLE, ROLES, SIDED_ROLES, SIDES, BodyPart, body_parts, part_label
from .schemes import SCHEMES, Scheme, sided

# With fewer limb segments than this, matching names ("head", "pelvis") are a coincidence, and the shape decides.
FEWEST_LIMB_SEGMENTS = 5
_LIMBS = tuple((role, side) for role in ("upper_arm", "forearm", "thigh", "shin") for side in SIDES)


@dataclass(frozen=True)
class Recognised:
    """The bones of a rig by body part.

    label: the kind of rig, for the user. chains: the bones of each part, from the body outward. ends: the bones whose
    mean head position is the end of a part's segment. edges: the two edge bones of a hand, by side. expected: for each
    missing part, the bone that this kind of rig should have, for error messages.
    """

    label: str
    chains: Mapping[BodyPart, tuple[str, ...]]
    ends: Mapping[BodyPart, tuple[str, ...]] = field(default_factory=dict)
    edges: Mapping[str, tuple[str, str]] = field(default_factory=dict)
    expected: Mapping[BodyPart, str] = field(default_factory=dict)


def recognise(rig: Object, corrections: Mapping[BodyPart, str] | None = None) -> Recognised:
    """The bones of a rig by body part, with the user's corrections.

    corrections: the first bone of a part's segment, or "" for a part that the rig does not have.
    Raises SinewError if the object is not an armature, if no limbs are found, or if a correction names an unknown bone or
    role.
    """
    if rig is None or rig.type != "ARMATURE":
        given = "nothing" if rig is None else f"'{rig.name}' ({rig.type.lower()})"
        raise SinewError(f"An armature is needed to find arms and legs, not {given}: select one, or its mesh")
    guess = _by_names(rig) or _by_shape(rig) or Recognised("by hand", {})
    recognised = _corrected(rig, guess, corrections or {})
    if not recognised.chains:
        known = ", ".join(scheme.label for scheme in SCHEMES)
        raise SinewError(
            f"'{rig.name}' isn't a rig that Sinew knows (it knows: {known}), and it has no two legs that mirror each "
            "other: name its bones in the table Bones of this operator, or use Add Muscles to Joints"
        )
    return recognised


def _by_names(rig: Object) -> Recognised | None:
    names = {}
    for bone in rig.data.bones:
        names.setdefault(_comparable(bone.name), bone.name)
    guesses = [_matched(scheme, names) for scheme in SCHEMES]
    best = max(guesses, key=lambda guess: len(guess.chains))
    return best if sum(limb in best.chains for limb in _LIMBS) >= FEWEST_LIMB_SEGMENTS else None


def _by_shape(rig: Object) -> Recognised | None:
    chains = topology.chains_of(rig)
    return Recognised("a rig recognised by its shape", chains) if chains else None


def _comparable(name: str) -> str:
    """A bone name without namespace and case."""
    return name.rpartition(":")[2].lower()


def _matched(scheme: Scheme, names: Mapping[str, str]) -> Recognised:
    """The parts of a scheme whose required bones the rig has. names: the rig's bone names by comparable name."""

    def bones_of(role: str, side: str, table: Mapping[str, tuple[str, ...]]) -> tuple[str, ...]:
        candidates = (_comparable(sided(scheme, name, side)) for name in table.get(role, ()))
        return tuple(names[name] for name in candidates if name in names)

    chains, ends, expected = {}, {}, {}
    for role, side in body_parts():
        if role not in scheme.chains:
            continue
        required = [sided(scheme, name, side) for name in scheme.chains[role] if not name.endswith("?")]
        missing = [name for name in required if _comparable(name) not in names]
        if missing:
            expected[role, side] = missing[0]
            continue
        chains[role, side] = bones_of(role, side, scheme.chains)
        ends[role, side] = bones_of(role, side, scheme.ends)
    edges = {side: tuple(names.get(_comparable(sided(scheme, edge, side)), "") for edge in scheme.edges) for side in SIDES}
    return Recognised(scheme.label, chains, ends, edges, expected)


def _corrected(rig: Object, guess: Recognised, corrections: Mapping[BodyPart, str]) -> Recognised:
    chains = dict(guess.chains)
    changed = {}
    for (role, side), bone in corrections.items():
        _check_correction(rig, role, side, bone)
        if chains.get((role, side), ("",))[0] != bone:
            changed[role, side] = bone
    for part in changed:
        chains.pop(part, None)
    taken = set(changed.values())
    chains = {part: tuple(bone for bone in bones if bone not in taken) for part, bones in chains.items()}
    for part, bone in changed.items():
        if bone:
            chains[part] = (bone,)
    for part in changed:
        if part in chains:
            chains[part] = _down_to_next(rig, part, chains)
    ends = {part: bones for part, bones in guess.ends.items() if part not in changed}
    return replace(guess, chains={part: bones for part, bones in chains.items() if bones}, ends=ends)


def _check_correction(rig: Object, role: str, side: str, bone: str) -> None:
    if role not in ROLES or side not in (SIDES if role in SIDED_ROLES else ("",)):
        raise SinewError(f"Bones: there is no segment '{part_label(role, side)}'; the segments are {', '.join(ROLES)}")
    if bone and bone not in rig.data.bones:
        raise SinewError(f"Bones: the {part_label(role, side)} is set to '{bone}', but '{rig.name}' has no such bone")


def _down_to_next(rig: Object, part: BodyPart, chains: Mapping[BodyPart, tuple[str, ...]]) -> tuple[str, ...]:
    """The bones from a segment's first bone to the next segment. Split bones belong to the segment above them."""
    role, side = part
    first, following = chains[part][0], chains.get((NEXT_ROLE.get(role, ""), side), ())
    if not following:
        return (first,)
    between, bone = [], rig.data.bones[following[0]].parent
    while bone is not None and bone.name != first:
        between.append(bone.name)
        bone = bone.parent
    return (first, *reversed(between)) if bone is not None else (first,)
