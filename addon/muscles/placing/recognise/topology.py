# SPDX-License-Identifier: GPL-3.0-or-later
"""A body found in bones of any names: two legs that reach the ground, two arms or forelegs, the spine between.

Left and right are told by mirrored places (armature space, +X is left, Z up), joints by how limbs are divided: a knee
lies half-way, whatever a rig splits its bones into.
"""

import itertools
from dataclasses import dataclass

from bpy.types import Bone, Object
from mathutils import Vector

MIRROR_TOLERANCE_OF_SIZE = 0.01
SHORTEST_LIMB_OF_SIZE = 0.15
GROUND_OF_HEIGHT = 0.12
HAND_OF_ARM = (0.04, 0.3)  # the share of an arm's length that is its hand
FINGERS = 3
FACE = 3
MIDDLE_OF_LIMB = 0.01
UNUSED = 0.5  # how much a bone that isn't used weighs against parts of unequal length

Chains = dict[tuple[str, str], tuple[str, ...]]


@dataclass(frozen=True)
class _Limb:
    """A left limb: its bones from the body outward, the points that they run through, the bone that it hangs on."""

    bones: tuple[Bone, ...]
    points: tuple[Vector, ...]
    hangs_on: Bone | None

    @property
    def length(self) -> float:
        return _length(self.points)

    @property
    def lowest(self) -> float:
        return min(point.z for point in self.points)


def chains_of(rig: Object) -> Chains:
    """(role, side) to bone names, as far as a body is found; nothing where no two legs mirror each other."""
    bones = list(rig.data.bones)
    if len(bones) < 5:
        return {}
    ends = [point for bone in bones for point in (bone.head_local, bone.tail_local)]
    size_m = max(max(point[axis] for point in ends) - min(point[axis] for point in ends) for axis in range(3))
    partners = _partners(bones, MIRROR_TOLERANCE_OF_SIZE * size_m)
    limbs = [_limb(bone) for bone in partners if bone.parent is None or bone.parent not in partners]
    limbs = [limb for limb in limbs if limb.length > SHORTEST_LIMB_OF_SIZE * size_m]
    ground = min(point.z for point in ends)
    height = max(point.z for point in ends) - ground
    legs = [limb for limb in limbs if limb.lowest < ground + GROUND_OF_HEIGHT * height]
    if not legs:
        return {}
    mirrored = set(partners) | set(partners.values())
    hind, fore = _hind_and_fore(legs, [limb for limb in limbs if limb not in legs])
    on_fours = fore in legs
    chains = _spine(hind, fore, mirrored)
    left = _leg(hind, ground, on_fours) | (_arm(fore, ground if on_fours else None) if fore else {})
    for role, names in left.items():
        chains[role, "L"] = tuple(bone.name for bone in names)
        chains[role, "R"] = tuple(partners[bone].name for bone in names)
    return {place: names for place, names in chains.items() if names}


def _partners(bones: list[Bone], tolerance_m: float) -> dict[Bone, Bone]:
    """Each left bone's mirror image on the right."""

    def image(point: Vector) -> Vector:
        return Vector((-point.x, point.y, point.z))

    right = [bone for bone in bones if max(-bone.head_local.x, -bone.tail_local.x) > tolerance_m]
    found = {}
    for bone in bones:
        if max(bone.head_local.x, bone.tail_local.x) <= tolerance_m:
            continue
        head, tail = image(bone.head_local), image(bone.tail_local)
        for other in right:
            if (other.head_local - head).length < tolerance_m and (other.tail_local - tail).length < tolerance_m:
                if other not in found.values():
                    found[bone] = other
                    break
    return found


def _limb(root: Bone) -> _Limb:
    bones = _longest(root)
    points = tuple(bone.head_local.copy() for bone in bones) + (bones[-1].tail_local.copy(),)
    return _Limb(bones, points, root.parent)


def _longest(root: Bone) -> tuple[Bone, ...]:
    """The longest way from a bone outward."""
    ways = [_longest(child) for child in root.children]
    return (root, *max(ways, key=lambda way: _reach(root, way), default=()))


def _reach(root: Bone, way: tuple[Bone, ...]) -> float:
    return _length((root.head_local, *(bone.head_local for bone in way), way[-1].tail_local))


def _length(points) -> float:
    return sum((there - here).length for here, there in itertools.pairwise(points))


def _hind_and_fore(legs: list[_Limb], others: list[_Limb]) -> tuple[_Limb, _Limb | None]:
    """Of two pairs that stand on the ground the one nearer to the root is hind; of one, the arms are the longest others."""
    legs = sorted(legs, key=lambda limb: -limb.length)[:2]
    if len(legs) == 2:
        return tuple(sorted(legs, key=lambda limb: len(limb.hangs_on.parent_recursive) if limb.hangs_on else 0))
    above = [limb for limb in others if limb.points[0].z > legs[0].points[0].z]
    return legs[0], max(above, key=lambda limb: limb.length, default=None)


def _spine(hind: _Limb, fore: _Limb | None, mirrored: set[Bone]) -> Chains:
    if hind.hangs_on is None or fore is None or fore.hangs_on is None:
        return {}
    trunk, bone = [], fore.hangs_on
    while bone is not None and bone != hind.hangs_on:
        trunk.insert(0, bone)
        bone = bone.parent
    trunk.insert(0, hind.hangs_on)
    onward = _central_way(fore.hangs_on, mirrored, set(trunk))
    backward = _central_way(hind.hangs_on, mirrored, {*trunk, *onward})
    middle = max(len(trunk) // 2, 1) if len(trunk) > 2 else 1
    skull = _skull(onward)
    thirds = [len(backward) * share // 3 for share in range(4)]
    chains = {
        ("pelvis", ""): trunk[:1],
        ("abdomen", ""): trunk[1:middle],
        ("chest", ""): trunk[middle:],
        ("neck", ""): onward[:skull],
        ("head", ""): onward[skull : skull + 1],
    }
    tail_roles = ("tail_base", "tail_middle", "tail_tip")
    chains |= {(role, ""): backward[thirds[i] : thirds[i + 1]] for i, role in enumerate(tail_roles)}
    return {place: tuple(bone.name for bone in bones) for place, bones in chains.items()}


def _skull(onward: list[Bone]) -> int:
    """The longest bone beyond the shoulders, up to where a face branches off: a jaw, nose or tongue may go on."""
    face = next((i for i, bone in enumerate(onward) if len(bone.children) >= FACE), len(onward) - 1)
    return max(range(face + 1), key=lambda i: onward[i].length, default=0)


def _central_way(root: Bone, mirrored: set[Bone], used: set[Bone]) -> list[Bone]:
    """The longest way onward along the middle of the body."""
    ways = [
        [child, *_central_way(child, mirrored, used)]
        for child in root.children
        if child not in mirrored and child not in used
    ]
    return max(ways, key=lambda way: _reach(root, tuple(way)), default=[])


def _leg(limb: _Limb, ground: float, on_fours: bool) -> dict[str, tuple[Bone, ...]]:
    """Two equal parts and a foot; three and toes where the heel is off the ground."""
    floor = ground + GROUND_OF_HEIGHT * (limb.points[0].z - ground)
    low = next((i for i, point in enumerate(limb.points[:-1]) if point.z < floor and i > 1), len(limb.bones))
    if on_fours and low > 2:
        hip, knee, hock = _divided(limb.points, low, 3)
        return {
            "thigh": limb.bones[hip:knee],
            "shin": limb.bones[knee:hock],
            "foot": limb.bones[hock:low],
            "toes": limb.bones[low : low + 1],
        }
    hip, knee = _divided(limb.points, low, 2)
    return {
        "thigh": limb.bones[hip:knee],
        "shin": limb.bones[knee:low],
        "foot": limb.bones[low : low + 1],
        "toes": limb.bones[low + 1 : low + 2],
    }


def _arm(limb: _Limb, ground: float | None) -> dict[str, tuple[Bone, ...]]:
    """Two equal parts before the wrist, and a shoulder girdle before them; a foreleg's is as long as they are."""
    wrist = _wrist(limb, ground)
    if ground is not None and wrist > 2:
        _, shoulder, elbow = _divided(limb.points, wrist, 3)
    else:
        shoulder, elbow = _divided(limb.points, wrist, 2)
    return {
        "shoulder_girdle": limb.bones[:shoulder],
        "upper_arm": limb.bones[shoulder:elbow],
        "forearm": limb.bones[elbow:wrist],
        "hand": limb.bones[wrist : wrist + 1],
        "fingers": limb.bones[wrist + 1 : wrist + 2],
    }


def _wrist(limb: _Limb, ground: float | None) -> int:
    last = len(limb.bones)
    if ground is not None:
        floor = ground + GROUND_OF_HEIGHT * (limb.points[0].z - ground)
        return next((i for i, point in enumerate(limb.points[:-1]) if point.z < floor and i > 1), last - 1)
    fanned = [i for i, bone in enumerate(limb.bones) if len(bone.children) >= FINGERS and i > 1]
    if fanned:
        return fanned[0]
    least, most = (share * limb.length for share in HAND_OF_ARM)
    return next((i for i in range(2, last) if least < _length(limb.points[i:]) < most), max(last - 1, 2))


def _divided(points: tuple[Vector, ...], last: int, parts: int) -> tuple[int, ...]:
    """Indices of the joints that divide the way up to point `last` into parts most alike, using most of the way.

    A limb doesn't begin in the middle of the body: a bone from there to the joint is no part of it.
    """
    whole_m = _length(points[: last + 1]) or 1.0
    first = next((i for i in range(max(last - parts, 0)) if points[i].x > MIDDLE_OF_LIMB * whole_m), max(last - parts, 0))

    def unlike(cuts: tuple[int, ...]) -> float:
        lengths = [(points[there] - points[here]).length for here, there in itertools.pairwise((*cuts, last))]
        return (max(lengths) - min(lengths) + UNUSED * _length(points[: cuts[0] + 1])) / whole_m

    choices = itertools.combinations(range(first, last), min(parts, last))
    best = min(choices, key=unlike)
    return best if len(best) == parts else (*best, *[last] * (parts - len(best)))
