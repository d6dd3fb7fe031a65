# SPDX-License-Identifier: GPL-3.0-or-later
"""Which bones of a rig belong to which body part, corrected by the user.

Known kinds of rig are recognised by their exact names, others by the words of their names, else by their shape.

The result names a bone for every part that was found, so that the user can correct each part separately.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

from bpy.types import Object
from mathutils import Vector

from ....errors import SinewError
from ....scene import characters, skinned_bones
from . import fish, names, tails, topology, wings
from .body_parts import NEXT_ROLE, OPTIONAL_ROLES, ROLES, SIDED_ROLES, SIDES, TRUNK_ROLES, BodyPart, body_parts, part_label
from .kind import BIRD, FISH, QUADRUPED
from .schemes import SCHEMES, Scheme, sided

# With fewer limb segments than this, matching names ("head", "pelvis") are a coincidence, and the shape decides.
FEWEST_LIMB_SEGMENTS = 5
_LIMBS = tuple((role, side) for role in ("upper_arm", "forearm", "thigh", "shin") for side in SIDES)


@dataclass(frozen=True)
class Recognised:
    """The bones of a rig by body part.

    label: the kind of rig, for the user. chains: the bones of each part, from the body outward. ends: the bones whose
    mean head position is the end of a part's segment. edges: the two edge bones of a hand, by side. expected: for each
    missing part, the bone that this kind of rig should have, for error messages. lines: where each of a part's bones starts,
    the part's start and its end, in armature space, for parts whose bones do not point from the body outward. left: unit,
    in armature space, for a body whose left and right no limbs tell.
    """

    label: str
    chains: Mapping[BodyPart, tuple[str, ...]]
    ends: Mapping[BodyPart, tuple[str, ...]] = field(default_factory=dict)
    edges: Mapping[str, tuple[str, str]] = field(default_factory=dict)
    expected: Mapping[BodyPart, str] = field(default_factory=dict)
    lines: Mapping[BodyPart, tuple[tuple[Vector, ...], Vector, Vector]] = field(default_factory=dict)
    left: Vector | None = None


def recognise(rig: Object, corrections: Mapping[BodyPart, str] | None = None, kind: str = "") -> Recognised:
    """The bones of a rig by body part, with the user's corrections.

    corrections: the first bone of a part's segment, or "" for a part that the rig does not have.
    kind: the kind of creature that the bones are looked for as: a fish's along its body, a bird's wings as arms. Raises
    SinewError if the object is not an armature, if no limbs are found, or if a correction names an unknown bone or role.
    """
    if rig is None or rig.type != "ARMATURE":
        given = "nothing" if rig is None else f"'{rig.name}' ({rig.type.lower()})"
        raise SinewError(f"An armature is needed to find arms and legs, not {given}: select one, or its mesh")
    guess = _guess_of_kind(rig, kind) or Recognised("by hand", {})
    recognised = _corrected(rig, guess, corrections or {})
    if not recognised.chains:
        known = ", ".join(scheme.label for scheme in SCHEMES)
        raise SinewError(
            f"'{rig.name}' isn't a rig that Sinew knows (it knows: {known}), and it has no two legs that mirror each "
            "other: name its bones in the table Bones of this operator, or use Add Muscles to Joints"
        )
    return recognised


def _guess_of_kind(rig: Object, kind: str) -> Recognised | None:
    if kind == FISH:
        found = fish.fish_of(rig, skinned_bones.skinned_bones(rig, characters.skins_of(rig)))
        if found is None:
            return None
        return Recognised("a fish recognised by its shape", found.chains, lines=found.lines, left=found.left)
    guess = _guess(rig)
    if guess is not None:
        guess = replace(guess, chains=_neck_beyond_arms(rig, guess.chains))
    if kind == BIRD and guess is not None:
        guess = replace(guess, chains={**guess.chains, **wings.chains_of(rig, guess.chains)})
    if kind in (QUADRUPED, BIRD) and guess is not None:
        guess = replace(guess, chains={**guess.chains, **tails.chains_of(rig, guess.chains)})
    return guess


def _neck_beyond_arms(rig: Object, chains: Mapping[BodyPart, tuple[str, ...]]) -> dict[BodyPart, tuple[str, ...]]:
    """The chains, with the bones of the neck that both arms hang from moved to the chest: spines count their bones
    differently. One bone remains the neck.
    """
    roots = [chains.get(("shoulder_girdle", side)) or chains.get(("upper_arm", side)) for side in SIDES]
    neck, chest = chains.get(("neck", ""), ()), chains.get(("chest", ""), ())
    if not all(roots) or not chest or not neck:
        return dict(chains)
    above = [{up.name for up in rig.data.bones[root[0]].parent_recursive} for root in roots]
    carrying = max((index + 1 for index, bone in enumerate(neck[:-1]) if all(bone in ups for ups in above)), default=0)
    return {**chains, ("chest", ""): chest + neck[:carrying], ("neck", ""): neck[carrying:]}


def _guess(rig: Object) -> Recognised | None:
    """The parts of a known kind of rig, completed by the words of the names; else by words or by shape.

    A body whose arms are named as legs in front is recognised by its shape where that agrees with the names: the names of
    four-legged creatures count their joints in different ways.
    """
    by_scheme = _by_scheme(rig)
    if by_scheme is not None and _is_complete(by_scheme):
        return by_scheme
    named = names.parts_of(rig)
    if by_scheme is not None:
        return _completed(by_scheme, named)
    by_words = Recognised("a rig recognised by the words of its names", named.chains, named.ends, named.edges)
    if _limbs_of(by_words) >= FEWEST_LIMB_SEGMENTS and not named.forelegs:
        return by_words
    by_shape = _by_shape(rig)
    if by_shape is not None and _is_complete(by_shape) and _agree(by_shape, by_words):
        return by_shape
    more_by_words = by_shape is None or len(by_words.chains) >= len(by_shape.chains)
    if _limbs_of(by_words) >= FEWEST_LIMB_SEGMENTS or (more_by_words and _has_pair(by_words.chains)):
        return by_words
    return by_shape


def _has_pair(chains: Mapping[BodyPart, tuple[str, ...]]) -> bool:
    """Whether two long parts of the legs or of the arms were found on both sides."""
    pairs = (("thigh", "shin"), ("upper_arm", "forearm"))
    return any(all((role, side) in chains for role in roles for side in SIDES) for roles in pairs)


def _limbs_of(guess: Recognised) -> int:
    return sum(limb in guess.chains for limb in _LIMBS)


def _agree(one: Recognised, other: Recognised) -> bool:
    """Whether the limbs that both guesses have start with the same bones."""
    return all(
        one.chains[limb][0] == other.chains[limb][0] for limb in _LIMBS if limb in one.chains and limb in other.chains
    )


def _is_complete(guess: Recognised) -> bool:
    return all(part in guess.chains for part in body_parts() if part[0] not in OPTIONAL_ROLES)


def _by_scheme(rig: Object) -> Recognised | None:
    bones = {}
    for bone in rig.data.bones:
        bones.setdefault(_comparable(bone.name), bone.name)
    best = max((_matched(scheme, bones) for scheme in SCHEMES), key=lambda guess: len(guess.chains))
    return best if _limbs_of(best) >= FEWEST_LIMB_SEGMENTS else None


def _completed(guess: Recognised, named: names.Named) -> Recognised:
    """A guess with the parts that it lacks and the words of the names tell.

    The trunk is one part here: a spine has any number of bones, and which of them is the chest depends on all.
    """
    chains = dict(guess.chains)
    known = {bone for part, bones in chains.items() if part[0] in TRUNK_ROLES for bone in bones}
    trunk = {part: bones for part, bones in named.chains.items() if part[0] in TRUNK_ROLES}
    if ("pelvis", "") in trunk and known <= {bone for bones in trunk.values() for bone in bones}:
        chains = {part: bones for part, bones in chains.items() if part[0] not in TRUNK_ROLES} | trunk
    used = {bone for bones in chains.values() for bone in bones}
    chains |= {part: bones for part, bones in named.chains.items() if part not in chains and not used & set(bones)}
    ends = {part: bones for part, bones in named.ends.items() if part in chains} | {k: v for k, v in guess.ends.items() if v}
    edges = {
        side: guess.edges[side] if all(guess.edges.get(side, ("",))) else named.edges.get(side, ("", "")) for side in SIDES
    }
    return replace(guess, chains=chains, ends=ends, edges=edges)


def _by_shape(rig: Object) -> Recognised | None:
    chains = topology.chains_of(rig, skinned_bones.skinned_bones(rig, characters.skins_of(rig)))
    return Recognised("a rig recognised by its shape", chains) if chains else None


def _comparable(name: str) -> str:
    """A bone name without namespace and case."""
    return name.rpartition(":")[2].lower()


def _matched(scheme: Scheme, bones: Mapping[str, str]) -> Recognised:
    """The parts of a scheme whose required bones the rig has. bones: the rig's bone names by comparable name."""

    def bones_of(role: str, side: str, table: Mapping[str, tuple[str, ...]]) -> tuple[str, ...]:
        candidates = (_comparable(sided(scheme, name, side)) for name in table.get(role, ()))
        return tuple(bones[name] for name in candidates if name in bones)

    chains, ends, expected = {}, {}, {}
    for role, side in body_parts():
        if role not in scheme.chains:
            continue
        required = [sided(scheme, name, side) for name in scheme.chains[role] if not name.endswith("?")]
        missing = [name for name in required if _comparable(name) not in bones]
        if missing:
            expected[role, side] = missing[0]
            continue
        chains[role, side] = bones_of(role, side, scheme.chains)
        ends[role, side] = bones_of(role, side, scheme.ends)
    edges = {side: tuple(bones.get(_comparable(sided(scheme, edge, side)), "") for edge in scheme.edges) for side in SIDES}
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
    expected = {part: bone for part, bone in guess.expected.items() if part not in corrections}
    lines = {part: line for part, line in guess.lines.items() if not changed}
    found = {part: bones for part, bones in chains.items() if bones}
    return replace(guess, chains=found, ends=ends, expected=expected, lines=lines)


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
