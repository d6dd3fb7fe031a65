# SPDX-License-Identifier: GPL-3.0-or-later
"""A body found by the words of its bone names, in any convention and language, and by the order of the bones.

A word can mean two parts: a shoulder is a collar bone or an upper arm, a leg is a thigh or a shin. Each limb takes the
reading that fits the order of its bones best. The trunk consists of the bones between the legs and the arms.
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field

from bpy.types import Bone, Object
from mathutils import Vector

from .body_parts import SIDES, BodyPart
from .limbs import longest_below
from .name_words import OF_ARM, OF_LEG, SIDE_LETTERS, Reading, prefixes_of, read

Chains = dict[BodyPart, tuple[str, ...]]
ARM = ("shoulder_girdle", "upper_arm", "forearm", "hand", "fingers")
LEG = ("thigh", "shin", "foot", "toes")
# How well a word fits a role. The numbers order the readings of a chain and have no other meaning.
FIT = {
    "girdle": {"shoulder_girdle": 3.0},
    "shoulder": {"shoulder_girdle": 2.0, "upper_arm": 1.5},
    "upper_arm": {"upper_arm": 3.0},
    "arm": {"upper_arm": 2.0, "forearm": 0.5},
    "elbow": {"forearm": 2.5},
    "forearm": {"forearm": 3.0},
    "wrist": {"hand": 2.9},
    "hand": {"hand": 3.0},
    "middle": {"fingers": 2.0},
    "index": {"fingers": 1.6},
    "ring": {"fingers": 1.5},
    "little": {"fingers": 1.0},
    "finger": {"fingers": 1.2},
    "thumb": {"fingers": 0.1},
    "hip": {"thigh": 2.0},
    "thigh": {"thigh": 3.0},
    "leg": {"thigh": 1.5, "shin": 1.4},
    "leg_or_foot": {"thigh": 1.5, "shin": 1.4, "foot": 1.3},
    "knee": {"shin": 2.5},
    "shin": {"shin": 3.0},
    "ankle": {"foot": 2.9},
    "foot": {"foot": 3.0, "toes": 1.4},
    "toes": {"toes": 3.0},
}
FORELEG = {"thigh": "upper_arm", "shin": "forearm", "foot": "hand", "toes": "fingers"}
BOTH_LONG_PARTS = 1.0  # for a limb with both its long bones
REPEATED = 0.2  # for a further bone of the same part
NO_DEFORM = 0.8  # factor of a bone that moves no skin
PER_UNKNOWN_WORD = 0.05
MOST_UNKNOWN_WORDS = 6
# A hand or foot at least this long, as a fraction of the part above it, is a forearm or shin where those are missing.
LONG_EXTREMITY = 0.7
# Farthest start of a foot or hand that has another parent: from the tail of the part above it, in lengths of that bone, and
# from its head, in lengths of the part before it. The tails of imported bones have no meaning.
FARTHEST_FROM_TAIL = 0.6
FARTHEST_FROM_HEAD = 1.5
NEAR_HIPS = 0.5  # of the distance from the hips to the shoulders, within which a bone is at the hips


@dataclass
class Named:
    """The parts that names tell. ends, edges: as in `Recognised`. forelegs: the arms are named as legs in front."""

    chains: Chains = field(default_factory=dict)
    ends: dict[BodyPart, tuple[str, ...]] = field(default_factory=dict)
    edges: dict[str, tuple[str, str]] = field(default_factory=dict)
    forelegs: bool = False


def parts_of(rig: Object) -> Named:
    """The body parts that the names of a rig's bones tell. Empty if they tell nothing."""
    readings = readings_of(rig)
    named = Named()
    limbs: dict[str, dict[str, list[Bone]]] = {}
    for side in SIDES:
        sided = {bone: reading for bone, reading in readings.items() if reading.side == side and not reading.other}
        arm = _limb({bone: _arm_fit(bone, reading) for bone, reading in sided.items()}, ARM)
        leg = _limb({bone: _leg_fit(bone, reading) for bone, reading in sided.items()}, LEG)
        limbs[side] = arm | leg
        named.forelegs |= any(readings[bones[0]].part in OF_LEG for bones in arm.values())
        _add_fingers(named, side, arm, sided)
    _lengthen(limbs, ("upper_arm", "forearm", "hand"))
    _lengthen(limbs, ("thigh", "shin", "foot"))
    for side, parts in limbs.items():
        named.chains |= {(role, side): tuple(bone.name for bone in bones) for role, bones in parts.items()}
    central = {bone: reading for bone, reading in readings.items() if not reading.side and _is_central(reading)}
    named.chains |= _middle(central, limbs)
    named.ends = {part: bones for part, bones in named.ends.items() if part in named.chains}
    return named


def readings_of(rig: Object) -> dict[Bone, Reading]:
    """What the names of all bones say, by the first letters for left and right that mark limbs on both sides."""
    prefixes = prefixes_of(rig.data.bones.keys())
    for letters in SIDE_LETTERS:
        readings = {bone: read(bone.name, letters, prefixes) for bone in rig.data.bones}
        if {reading.side for reading in readings.values() if reading.part in OF_ARM | OF_LEG} >= set(SIDES):
            return readings
    return {bone: read(bone.name, prefixes=prefixes) for bone in rig.data.bones}


def _weight(bone: Bone, reading: Reading) -> float:
    deforming = 1.0 if bone.use_deform else NO_DEFORM
    return deforming - PER_UNKNOWN_WORD * min(reading.unknown, MOST_UNKNOWN_WORDS)


def _arm_fit(bone: Bone, reading: Reading) -> dict[str, float]:
    if reading.part in OF_ARM:
        fits = FIT[reading.part]
    elif reading.part in OF_LEG and reading.front:
        fits = {FORELEG[role]: fit for role, fit in FIT[reading.part].items()}
    else:
        return {}
    return {role: fit * _weight(bone, reading) for role, fit in fits.items()}


def _leg_fit(bone: Bone, reading: Reading) -> dict[str, float]:
    if reading.front or reading.part not in OF_LEG | {"hip"}:
        return {}
    return {role: fit * _weight(bone, reading) for role, fit in FIT[reading.part].items()}


def _limb(fits: Mapping[Bone, Mapping[str, float]], roles: tuple[str, ...]) -> dict[str, list[Bone]]:
    """The bones of each part of one limb, along the chain of bones that fits best, and parts that have another parent."""
    fits = {bone: fit for bone, fit in fits.items() if fit}
    inner = {parent for bone in fits for parent in bone.parent_recursive}
    best: tuple[float, list[tuple[Bone, str]]] = (0.0, [])
    for bone in fits:
        if bone not in inner:
            path = [each for each in (*reversed(bone.parent_recursive), bone) if each in fits]
            best = max(best, _assigned(path, fits, roles), key=lambda found: found[0])
    first: dict[str, Bone] = {}
    for bone, role in best[1]:
        first.setdefault(role, bone)
    _add_loose(first, fits, roles)
    return _with_split_bones(first, dict(best[1]), roles)


def _assigned(path: list[Bone], fits, roles: tuple[str, ...]) -> tuple[float, list[tuple[Bone, str]]]:
    """The roles of the bones of a path, in the order of `roles`, that fit best. A bone can have no role."""
    long_parts = sum(1 << roles.index(role) for role in ("upper_arm", "forearm", "thigh", "shin") if role in roles)
    states: dict[int, tuple[float, list[tuple[Bone, str]]]] = {0: (0.0, [])}
    for bone in path:
        reached = dict(states)
        for used, (score, given) in states.items():
            for index, role in enumerate(roles):
                if role not in fits[bone] or used >> (index + 1):
                    continue
                gained = REPEATED if used >> index & 1 else fits[bone][role]
                state = used | 1 << index
                if state not in reached or score + gained > reached[state][0]:
                    reached[state] = (score + gained, [*given, (bone, role)])
        states = reached
    complete = {used: BOTH_LONG_PARTS if used & long_parts == long_parts else 0.0 for used in states}
    best = max(states, key=lambda used: states[used][0] + complete[used])
    return states[best][0] + complete[best], states[best][1]


def _add_loose(first: dict[str, Bone], fits, roles: tuple[str, ...]):
    """Adds hands, feet and toes whose parent is a control bone. They start where the part above them ends."""
    for before, above, role in zip(roles, roles[1:], roles[2:], strict=False):
        if role in first or above not in first or before not in first or role not in ("hand", "foot", "toes"):
            continue
        upper = first[above]
        from_tail_m = FARTHEST_FROM_TAIL * upper.length
        from_head_m = FARTHEST_FROM_HEAD * (upper.head_local - first[before].head_local).length
        near = [
            bone
            for bone, fit in fits.items()
            if fit.get(role, 0.0) == max(fit.values())
            and bone not in first.values()
            and (
                (bone.head_local - upper.tail_local).length < from_tail_m
                or (bone.head_local - upper.head_local).length < from_head_m
            )
        ]
        if near:
            first[role] = max(near, key=lambda bone: (fits[bone][role], -len(bone.parent_recursive)))


def _with_split_bones(first: dict[str, Bone], given: Mapping[Bone, str], roles: tuple[str, ...]) -> dict[str, list[Bone]]:
    """Each part with the bones between its first bone and the next part. Split bones belong to the part above them."""
    limb = {}
    present = [role for role in roles if role in first]
    for role, following in zip(present, [*present[1:], None], strict=False):
        between: list[Bone] = []
        parents = first[following].parent_recursive if following else []
        if first[role] in parents:
            between = parents[: parents.index(first[role])][::-1]
        elif role not in ("hand", "fingers", "foot", "toes"):
            between = [bone for bone, its in given.items() if its == role and bone != first[role]]
        limb[role] = [first[role], *between]
    return limb


def _lengthen(limbs: Mapping[str, dict[str, list[Bone]]], roles: tuple[str, str, str]):
    """Takes a hand or foot that is as long as the part above it as the forearm or shin, where those are missing."""
    upper, lower, extremity = roles
    for parts in limbs.values():
        if upper not in parts or extremity not in parts or lower in parts:
            return
        start, end = parts[upper][0].head_local, parts[extremity][0].head_local
        if parts[extremity][0].length < LONG_EXTREMITY * (end - start).length:
            return
    for parts in limbs.values():
        parts[lower] = parts.pop(extremity)


def _add_fingers(named: Named, side: str, arm: Mapping[str, list[Bone]], sided: Mapping[Bone, Reading]):
    """Adds the end and the edges of a hand: the first bones of its four fingers."""
    if "hand" not in arm:
        return
    bases = {}
    for finger in ("index", "middle", "ring", "little"):
        bones = [
            bone for bone, reading in sided.items() if reading.part == finger and _is_below(bone, arm["hand"][0].parent)
        ]
        if bones:
            bases[finger] = min(bones, key=lambda bone: len(bone.parent_recursive)).name
    if bases:
        named.ends["hand", side] = tuple(bases.values())
    if "index" in bases and len(bases) > 1:
        named.edges[side] = (bases["index"], list(bases.values())[-1])


def _is_below(bone: Bone, ancestor: Bone | None) -> bool:
    return ancestor is None or ancestor in bone.parent_recursive


# The middle of the body


def _is_central(reading: Reading) -> bool:
    """Whether a bone in the middle can be a part of the body. A neck is one also as "NeckTwist01"."""
    return not reading.other or (reading.part == "neck" and not reading.control)


def _middle(central: Mapping[Bone, Reading], limbs: Mapping[str, Mapping[str, list[Bone]]]) -> Chains:
    """Pelvis, spine, neck, head, jaw and tail."""
    thighs = [parts["thigh"][0] for parts in limbs.values() if "thigh" in parts]
    arms = [
        next(bones[0] for role in ARM if (bones := parts.get(role))) for parts in limbs.values() if set(ARM) & set(parts)
    ]

    def named(*parts: str) -> list[Bone]:
        bones = [bone for bone, reading in central.items() if reading.part in parts]
        return sorted(bones, key=lambda bone: (-_weight(bone, central[bone]), len(bone.parent_recursive)))

    necks, heads = named("neck"), named("head")
    top = _top(central, arms, necks, heads)
    if top is None:
        top = _hips(thighs, arms)
    if not heads and not necks and top is not None:
        necks, heads = _beyond(top, central)
    pelvis = _pelvis(named("pelvis", "hip"), thighs, top, central)
    if pelvis is None:
        trunk = []
    else:
        trunk = _between(pelvis, top, central) if top is not None and top != pelvis else _down_trunk(pelvis, central)
    head = next((bone for bone in heads if top is None or _is_below(bone, top)), heads[0] if heads else None)
    neck = _neck(head, necks, trunk, central)
    spine = [bone for bone in neck if central.get(bone) and central[bone].part in ("trunk", "back") and bone not in necks]
    trunk += spine if necks else []
    neck = [bone for bone in neck if bone not in trunk]
    jaw = next((bone for bone in named("jaw") if head is None or _is_below(bone, head)), None)
    tail = _longest_named(named("tail"))
    middle = (len(trunk) + 1) // 2
    thirds = [len(tail) * third // 3 for third in range(4)]
    chains: dict[str, Iterable[Bone]] = {
        "pelvis": trunk[:1],
        "abdomen": trunk[1:middle],
        "chest": trunk[middle:],
        "neck": neck,
        "head": [head] if head else [],
        "jaw": [jaw] if jaw else [],
    }
    chains |= {role: tail[thirds[i] : thirds[i + 1]] for i, role in enumerate(("tail_base", "tail_middle", "tail_tip"))}
    return {(role, ""): tuple(bone.name for bone in bones) for role, bones in chains.items() if bones}


def _top(central, arms: list[Bone], necks: list[Bone], heads: list[Bone]) -> Bone | None:
    """The bone of the trunk that arms, neck or head grow from."""
    shared = _shared_parent(arms)
    for top in (shared, *(bone.parent for bone in (*necks, *heads))):
        if top is not None and top in central and central[top].part in ("trunk", "back", "pelvis", "hip"):
            return top
    return shared if shared is None or shared.parent is not None else None


def _hips(thighs: list[Bone], arms: list[Bone]) -> Bone | None:
    """The bone that legs and arms grow from, if it is nearer to the legs than half-way: not a root on the ground."""
    shared = _shared_parent([*thighs, *arms]) if thighs and arms else None
    if shared is None:
        return None
    hips, shoulders = (sum((bone.head_local for bone in bones), Vector()) / len(bones) for bones in (thighs, arms))
    return shared if (shared.head_local - hips).length < NEAR_HIPS * (shoulders - hips).length else None


def _beyond(top: Bone, central) -> tuple[list[Bone], list[Bone]]:
    """The neck and the head where all bones of the middle are named as a spine: the bones beyond the one that the arms grow
    from.
    """
    beyond = longest_below(top, lambda bone: bone in central and central[bone].part in ("trunk", "back"))
    return beyond[:-1], beyond[-1:]


def _shared_parent(bones: list[Bone]) -> Bone | None:
    """The nearest bone above all of these bones. None if there is none."""
    if not bones:
        return None
    return next((up for up in bones[0].parent_recursive if all(_is_below(bone, up) for bone in bones)), None)


def _pelvis(candidates: list[Bone], thighs: list[Bone], top: Bone | None, central) -> Bone | None:
    """The bone that carries the legs, by name; else the bone that both legs grow from."""
    legs = _shared_parent(thighs)
    if candidates:
        return max(
            candidates,
            key=lambda bone: (
                bool(thighs) and all(_is_below(thigh, bone) for thigh in thighs),
                top is not None and (top == bone or _is_below(top, bone)),
                len(bone.parent_recursive),
            ),
        )
    if legs is not None and legs in central and central[legs].part in ("trunk", "back"):
        return legs
    return legs if legs is not None and top is not None and (top == legs or _is_below(top, legs)) else None


def _between(pelvis: Bone, top: Bone, central) -> list[Bone]:
    """The bones from the pelvis to the top of the trunk.

    Where the pelvis is not above the top, the path goes through the bone that is above both.
    """
    down = [top, *top.parent_recursive]
    if pelvis in down:
        return down[: down.index(pelvis) + 1][::-1]
    up = [pelvis, *pelvis.parent_recursive]
    shared = next((bone for bone in up if bone in down), None)
    if shared is None:
        return [pelvis, *[bone for bone in reversed(down) if bone in central and central[bone].part in ("trunk", "back")]]
    turn = [shared] if shared in central and central[shared].part in ("trunk", "back") else []
    return [*up[: up.index(shared)], *turn, *down[: down.index(shared)][::-1]]


def _down_trunk(pelvis: Bone, central) -> list[Bone]:
    """The pelvis and the bones below it that are named as parts of the trunk."""
    chain = [pelvis]
    while True:
        below = [bone for bone in chain[-1].children if bone in central and central[bone].part in ("trunk", "back")]
        if not below:
            return chain
        chain.append(below[0])


def _neck(head: Bone | None, necks: list[Bone], trunk: list[Bone], central) -> list[Bone]:
    """The bones between the trunk and the head; without a head, the bones that are named so."""
    if head is not None and trunk and _is_below(head, trunk[-1]):
        parents = head.parent_recursive
        return parents[: parents.index(trunk[-1])][::-1]
    return _longest_named(necks)


def _longest_named(bones: list[Bone]) -> list[Bone]:
    """The longest chain among these bones, from the body outward."""
    chains = [[*(up for up in reversed(bone.parent_recursive) if up in bones), bone] for bone in bones]
    return max(chains, key=len, default=[])


# Other creatures


def leg_pairs(rig: Object) -> int:
    """The number of legs on the side that has more of them, by name. A bone above which no bone of a leg is starts a leg."""
    counts, readings = [], readings_of(rig)
    for side in SIDES:
        legs = {bone for bone, said in readings.items() if said.side == side and said.part in OF_LEG and not said.other}
        roots = [bone for bone in legs if not legs & set(bone.parent_recursive)]
        counts.append(sum(any(child in legs for child in bone.children) for bone in roots))
    return max(counts)


def has_part(rig: Object, part: str) -> bool:
    """Whether bones of the rig are named as this kind of part: "wing", "fin"."""
    return any(reading.part == part and not reading.other for reading in readings_of(rig).values())
