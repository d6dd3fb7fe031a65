# SPDX-License-Identifier: GPL-3.0-or-later
"""The wings of a bird as arms: upper arm, forearm and hand are the same bones in birds and humans."""

from collections.abc import Mapping

from bpy.types import Bone, Object

from .body_parts import TRUNK_ROLES, BodyPart
from .body_space import body_space
from .limbs import MIDDLE_OF_LIMB, limbs_of, longest_below
from .name_words import Reading
from .names import readings_of

PARTS = ("upper_arm", "forearm", "hand")
FEWEST_BONES = 2
FEATHERS = frozenset({"feather", "feathers", "plume", "feder", "pluma", "piuma", "pena", "перо", "羽毛"})


def chains_of(rig: Object, known: Mapping[BodyPart, tuple[str, ...]]) -> dict[BodyPart, tuple[str, ...]]:
    """The bones of upper arm, forearm and hand of the longest pair of wings. Empty if the bird has arms by name, or no
    wings.

    known: the parts that were found before.
    """
    if ("upper_arm", "L") in known or ("upper_arm", "R") in known:
        return {}
    readings = readings_of(rig)
    bones = [bone for bone, reading in readings.items() if not reading.control]
    if not bones:
        return {}
    space = body_space(rig, readings, bones)
    used = {bone for chain in known.values() for bone in chain}
    limbs = [limb for limb in limbs_of(space, bones, readings, ()) if readings[limb.bones[0]].part == "wing"]
    if not limbs:
        return {}
    longest = max(limbs, key=lambda limb: limb.length)
    root = longest.bones[0]
    wing = [root, *longest_below(root, lambda child: child in space.partners and not _is_feather(readings[child]))]
    if used & {bone.name for bone in wing} or len(wing) < FEWEST_BONES:
        return {}
    starts_in_middle = space.head(root).x < MIDDLE_OF_LIMB * longest.length
    first = 1 if starts_in_middle and len(wing) > FEWEST_BONES else 0
    cuts = (first, first + 1, first + 2) if len(wing) > first + 2 else (first, first + 1, len(wing))
    chains = _with_neck(rig, known, root)
    for side, bones_of_side in (("L", wing), ("R", [space.partners[bone] for bone in wing])):
        ends = (*cuts[1:], len(wing))
        for role, start, end in zip(("shoulder_girdle", *PARTS), (0, *cuts), (cuts[0], *ends), strict=True):
            if bones_of_side[start:end]:
                chains[role, side] = tuple(bone.name for bone in bones_of_side[start:end])
    return chains


def _with_neck(rig: Object, known: Mapping[BodyPart, tuple[str, ...]], root: Bone) -> dict[BodyPart, tuple[str, ...]]:
    """The trunk up to the bone that the wings grow from, and the neck beyond it, where no name tells the neck."""
    head = known.get(("head", ""))
    if ("neck", "") in known or not head or root.parent is None:
        return {}
    below_head = [bone.name for bone in reversed(rig.data.bones[head[0]].parent_recursive)]
    trunk = [name for role in TRUNK_ROLES for name in known.get((role, ""), ())]
    if root.parent.name not in below_head or root.parent.name not in trunk:
        return {}
    neck = below_head[below_head.index(root.parent.name) + 1 :]
    trunk = [name for name in trunk if name not in neck]
    if not neck or len(trunk) < FEWEST_BONES:
        return {}
    middle = (len(trunk) + 1) // 2
    parts = {"pelvis": trunk[:1], "abdomen": trunk[1:middle], "chest": trunk[middle:], "neck": neck}
    return {(role, ""): tuple(names) for role, names in parts.items() if names}


def _is_feather(reading: Reading) -> bool:
    return not FEATHERS.isdisjoint(reading.rest)
