# SPDX-License-Identifier: GPL-3.0-or-later
"""A body found by the shape of a rig: two legs that reach the ground, two arms or forelegs, and the spine between them.

Bone names do not matter. Left and right follow from mirrored positions (armature space: +X is left, Z is up). Joints follow
from the division of a limb into equal parts: a knee is half-way, however many bones the rig has there.
"""

import itertools
from collections.abc import Callable, Mapping
from dataclasses import dataclass

from bpy.types import Bone, Object
from mathutils import Vector

from .body_parts import BodyPart
from .names import readings_of

MIRROR_TOLERANCE_OF_SIZE = 0.01
SHORTEST_LIMB_OF_SIZE = 0.15
GROUND_OF_HEIGHT = 0.12
HAND_OF_ARM = (0.04, 0.3)  # smallest and largest length of a hand, as fractions of the arm's length
FEWEST_LIMB_BONES = 2
FEWEST_FINGERS = 3  # a bone with this many children is a hand
FEWEST_FACE_BONES = 3  # a bone with this many children has a face
MIDDLE_OF_LIMB = 0.01  # fraction of a limb's length within which a joint is in the middle of the body
UNUSED_COST = 0.5  # cost of the unused length of a limb, against the difference between the lengths of its parts

NO_LIMBS = ("wing", "fin", "tail")  # parts in pairs that are no legs or arms, by name

Chains = dict[BodyPart, tuple[str, ...]]


@dataclass(frozen=True)
class _Limb:
    """A left limb: its bones from the body outward, their joints and last tail, and the bone that it branches off."""

    bones: tuple[Bone, ...]
    points: tuple[Vector, ...]
    parent: Bone | None

    @property
    def length(self) -> float:
        return _length(self.points)

    @property
    def lowest(self) -> float:
        return min(point.z for point in self.points)


def chains_of(rig: Object) -> Chains:
    """The bone names of each body part that was found. Empty if there are no two legs that mirror each other."""
    readings = readings_of(rig)
    bones = [bone for bone, reading in readings.items() if not reading.control]
    if len(bones) < 5:
        return {}
    ends = [point for bone in bones for point in (bone.head_local, bone.tail_local)]
    size_m = max(max(point[axis] for point in ends) - min(point[axis] for point in ends) for axis in range(3))
    partners = _partners(bones, MIRROR_TOLERANCE_OF_SIZE * size_m)
    limbs = [_limb(bone, partners) for bone in partners if bone.parent is None or bone.parent not in partners]
    limbs = [limb for limb in limbs if readings[limb.bones[0]].part not in NO_LIMBS]
    limbs = [limb for limb in limbs if limb.length > SHORTEST_LIMB_OF_SIZE * size_m and len(limb.bones) >= FEWEST_LIMB_BONES]
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
    return {part: names for part, names in chains.items() if names}


def _partners(bones: list[Bone], tolerance_m: float) -> dict[Bone, Bone]:
    """The mirror image on the right of each left bone that has one."""

    def image(point: Vector) -> Vector:
        return Vector((-point.x, point.y, point.z))

    right = [bone for bone in bones if max(-bone.head_local.x, -bone.tail_local.x) > tolerance_m]
    partners = {}
    for bone in bones:
        if max(bone.head_local.x, bone.tail_local.x) <= tolerance_m:
            continue
        head, tail = image(bone.head_local), image(bone.tail_local)
        for candidate in right:
            distance_m = max((candidate.head_local - head).length, (candidate.tail_local - tail).length)
            if distance_m < tolerance_m and candidate not in partners.values():
                partners[bone] = candidate
                break
    return partners


def _limb(root: Bone, partners: Mapping[Bone, Bone]) -> _Limb:
    bones = _longest(root, partners)
    points = tuple(bone.head_local.copy() for bone in bones) + (bones[-1].tail_local.copy(),)
    return _Limb(bones, points, root.parent)


def _longest(root: Bone, partners: Mapping[Bone, Bone]) -> tuple[Bone, ...]:
    """The longest chain of bones that starts with this one. Bones without a mirror image on the right are not part of it."""
    return (root, *_longest_below(root, lambda child: child in partners))


def _longest_below(root: Bone, belongs: Callable[[Bone], bool]) -> list[Bone]:
    """The longest chain of bones that starts with a child of this one, along bones that belong to it.

    It has no recursion, because a chain can have more bones than Python allows nested calls.
    """
    bones = [root]
    for bone in bones:
        bones += [child for child in bone.children if belongs(child)]
    length_m: dict[Bone, float] = {}
    longest: dict[Bone, Bone] = {}
    for bone in reversed(bones):
        lengths = {c: (c.head_local - bone.head_local).length + length_m[c] for c in bone.children if c in length_m}
        if lengths:
            longest[bone] = max(lengths, key=lengths.get)
        length_m[bone] = lengths[longest[bone]] if lengths else bone.length
    chain, bone = [], root
    while bone in longest:
        bone = longest[bone]
        chain.append(bone)
    return chain


def _length(points) -> float:
    return sum((there - here).length for here, there in itertools.pairwise(points))


def _hind_and_fore(legs: list[_Limb], off_ground: list[_Limb]) -> tuple[_Limb, _Limb | None]:
    """The hind limb and the fore limb.

    Of two limbs on the ground, the hind one is nearer to the root bone. With one on the ground, the fore limb is the
    longest of those that start above it.
    """
    legs = sorted(legs, key=lambda limb: -limb.length)[:2]
    if len(legs) == 2:
        return tuple(sorted(legs, key=lambda limb: len(limb.parent.parent_recursive) if limb.parent else 0))
    above = [limb for limb in off_ground if limb.points[0].z > legs[0].points[0].z]
    return legs[0], max(above, key=lambda limb: limb.length, default=None)


def _spine(hind: _Limb, fore: _Limb | None, mirrored: set[Bone]) -> Chains:
    """Pelvis, abdomen, chest, neck, head and tail, from the bones between the limbs and beyond them."""
    if hind.parent is None or fore is None or fore.parent is None:
        return {}
    trunk, bone = [], fore.parent
    while bone is not None and bone != hind.parent:
        trunk.insert(0, bone)
        bone = bone.parent
    trunk.insert(0, hind.parent)
    forward = _central_chain(fore.parent, mirrored, set(trunk))
    backward = _central_chain(hind.parent, mirrored, {*trunk, *forward})
    middle = max(len(trunk) // 2, 1) if len(trunk) > 2 else 1
    skull = _skull(forward)
    thirds = [len(backward) * third // 3 for third in range(4)]
    chains = {
        ("pelvis", ""): trunk[:1],
        ("abdomen", ""): trunk[1:middle],
        ("chest", ""): trunk[middle:],
        ("neck", ""): forward[:skull],
        ("head", ""): forward[skull : skull + 1],
    }
    tail_roles = ("tail_base", "tail_middle", "tail_tip")
    chains |= {(role, ""): backward[thirds[i] : thirds[i + 1]] for i, role in enumerate(tail_roles)}
    return {part: tuple(bone.name for bone in bones) for part, bones in chains.items()}


def _skull(forward: list[Bone]) -> int:
    """The index of the longest bone beyond the shoulders, up to the bone with a face. A jaw or nose may follow it."""
    face = next((i for i, bone in enumerate(forward) if len(bone.children) >= FEWEST_FACE_BONES), len(forward) - 1)
    return max(range(face + 1), key=lambda i: forward[i].length, default=0)


def _central_chain(root: Bone, mirrored: set[Bone], used: set[Bone]) -> list[Bone]:
    """The longest chain below a bone along the middle of the body."""
    return _longest_below(root, lambda child: child not in mirrored and child not in used)


def _leg(limb: _Limb, ground: float, on_fours: bool) -> dict[str, tuple[Bone, ...]]:
    """Two equal parts and a foot. On four legs the heel is off the ground: three equal parts and toes."""
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
    """Shoulder girdle, two equal parts, hand. The shoulder girdle of a foreleg is as long as each of the two parts.

    ground: height of the ground under a foreleg, None for an arm.
    """
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
    """The index of the hand's bone: the first near the ground, the one with fingers, or the one that fits by length."""
    last = len(limb.bones)
    if ground is not None:
        floor = ground + GROUND_OF_HEIGHT * (limb.points[0].z - ground)
        return next((i for i, point in enumerate(limb.points[:-1]) if point.z < floor and i > 1), last - 1)
    with_fingers = [i for i, bone in enumerate(limb.bones) if len(bone.children) >= FEWEST_FINGERS and i > 1]
    if with_fingers:
        return with_fingers[0]
    least, most = (fraction * limb.length for fraction in HAND_OF_ARM)
    return next((i for i in range(2, last) if least < _length(limb.points[i:]) < most), min(max(last - 1, 2), last))


def _divided(points: tuple[Vector, ...], last: int, parts: int) -> tuple[int, ...]:
    """Indices of the joints that divide a limb up to point `last` into parts of similar length, and use most of its length.

    A limb does not start in the middle of the body: a bone from the middle to the first joint is not part of it.
    """
    whole_m = _length(points[: last + 1]) or 1.0
    first = next((i for i in range(max(last - parts, 0)) if points[i].x > MIDDLE_OF_LIMB * whole_m), max(last - parts, 0))

    def cost(cuts: tuple[int, ...]) -> float:
        lengths = [(points[there] - points[here]).length for here, there in itertools.pairwise((*cuts, last))]
        return (max(lengths) - min(lengths) + UNUSED_COST * _length(points[: cuts[0] + 1])) / whole_m

    choices = itertools.combinations(range(first, last), min(parts, last))
    best = min(choices, key=cost)
    return best if len(best) == parts else (*best, *[last] * (parts - len(best)))
