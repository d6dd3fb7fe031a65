# SPDX-License-Identifier: GPL-3.0-or-later
"""A body found by the shape of a rig: two legs that reach the ground, two arms or forelegs, and the spine between them.

Left, up and front follow from `body_space`. Joints follow from the division of a limb into equal parts: a knee is half-way,
however many bones the rig has there.
"""

import numpy as np
from bpy.types import Bone, Object
from mathutils import Vector

from ....scene.skinned_bones import SkinnedBones
from .body_parts import BodyPart
from .body_space import body_space
from .limbs import Limb, divided, limbs_of, longest_below, path_length
from .names import readings_of

FEWEST_BONES = 5
GROUND_OF_HEIGHT = 0.12
HAND_OF_ARM = (0.04, 0.3)  # smallest and largest length of a hand, as fractions of the arm's length
FEWEST_FINGERS = 3  # a bone with this many children is a hand
FEWEST_FACE_BONES = 3  # a bone with this many children has a face

FACE = ("head", "neck", "jaw")
NO_LIMBS = ("wing", "fin", "tail")  # parts in pairs that are no legs or arms, by name

Chains = dict[BodyPart, tuple[str, ...]]


def chains_of(rig: Object, skinned: SkinnedBones | None = None) -> Chains:
    """The bone names of each body part that was found. Empty if there are no two legs that mirror each other.

    skinned: which skin the bones carry. It tells the ground and the skull better than the tails of imported bones.
    """
    readings = readings_of(rig)
    bones = [bone for bone, reading in readings.items() if not reading.control]
    if len(bones) < FEWEST_BONES:
        return {}
    space = body_space(rig, readings, bones)
    limbs = limbs_of(space, bones, readings, NO_LIMBS)
    if skinned is not None and len(skinned.points):
        heights = space.heights(skinned.points)
    else:
        heights = np.array([point.z for bone in bones for point in (space.head(bone), space.end(bone))])
    ground, height = float(heights.min()), float(np.ptp(heights))
    legs = [limb for limb in limbs if limb.lowest < ground + GROUND_OF_HEIGHT * height]
    if not legs:
        return {}
    face = [space.head(bone) for bone, reading in readings.items() if reading.part in FACE and not reading.side]
    hind, fore = _hind_and_fore(legs, [limb for limb in limbs if limb not in legs], face)
    on_fours = fore in legs
    chains = _spine(hind, fore, space.mirrored, skinned)
    left = _leg(hind, ground, on_fours) | (_arm(fore, ground if on_fours else None) if fore else {})
    for role, names in left.items():
        chains[role, "L"] = tuple(bone.name for bone in names)
        chains[role, "R"] = tuple(space.partners[bone].name for bone in names)
    return {part: names for part, names in chains.items() if names}


def _hind_and_fore(legs: list[Limb], off_ground: list[Limb], face: list[Vector]) -> tuple[Limb, Limb | None]:
    """The hind limb and the fore limb.

    Of two limbs on the ground, the hind one is farther from the head and neck that names tell (`face`); without such names
    it is nearer to the root bone. With one on the ground, the fore limb is the longest of those that start above it.
    """
    legs = sorted(legs, key=lambda limb: -limb.length)[:2]
    if len(legs) == 2 and face:
        middle = sum(face, Vector()) / len(face)
        return tuple(sorted(legs, key=lambda limb: -(limb.points[0] - middle).length))
    if len(legs) == 2:
        return tuple(sorted(legs, key=lambda limb: len(limb.parent.parent_recursive) if limb.parent else 0))
    above = [limb for limb in off_ground if limb.points[0].z > legs[0].points[0].z]
    return legs[0], max(above, key=lambda limb: limb.length, default=None)


def _spine(hind: Limb, fore: Limb | None, mirrored: set[Bone], skinned: SkinnedBones | None) -> Chains:
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
    skull = _skull(forward, skinned)
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


def _skull(forward: list[Bone], skinned: SkinnedBones | None) -> int:
    """The index of the largest bone beyond the shoulders, up to the bone with a face. A jaw or nose may follow it.

    The size of a bone is that of the skin that it carries; its length if no bone carries skin.
    """
    face = next((i for i, bone in enumerate(forward) if len(bone.children) >= FEWEST_FACE_BONES), len(forward) - 1)
    sizes = [_size_of_skin(bone, skinned) for bone in forward[: face + 1]]
    if not any(sizes):
        sizes = [bone.length for bone in forward[: face + 1]]
    return max(range(face + 1), key=lambda i: sizes[i], default=0)


def _size_of_skin(bone: Bone, skinned: SkinnedBones | None) -> float:
    """The diagonal of the box around the skin that a bone carries; 0 without any."""
    points = skinned.points_of({bone.name}) if skinned is not None else ()
    return float(np.linalg.norm(np.ptp(points, axis=0))) if len(points) else 0.0


def _central_chain(root: Bone, mirrored: set[Bone], used: set[Bone]) -> list[Bone]:
    """The longest chain below a bone along the middle of the body."""
    return longest_below(root, lambda child: child not in mirrored and child not in used)


def _leg(limb: Limb, ground: float, on_fours: bool) -> dict[str, tuple[Bone, ...]]:
    """Two equal parts and a foot. On four legs the heel is off the ground: three equal parts and toes."""
    floor = ground + GROUND_OF_HEIGHT * (limb.points[0].z - ground)
    low = next((i for i, point in enumerate(limb.points[:-1]) if point.z < floor and i > 1), len(limb.bones))
    if on_fours and low > 2:
        hip, knee, hock = divided(limb.points, low, 3)
        return {
            "thigh": limb.bones[hip:knee],
            "shin": limb.bones[knee:hock],
            "foot": limb.bones[hock:low],
            "toes": limb.bones[low : low + 1],
        }
    hip, knee = divided(limb.points, low, 2)
    return {
        "thigh": limb.bones[hip:knee],
        "shin": limb.bones[knee:low],
        "foot": limb.bones[low : low + 1],
        "toes": limb.bones[low + 1 : low + 2],
    }


def _arm(limb: Limb, ground: float | None) -> dict[str, tuple[Bone, ...]]:
    """Shoulder girdle, two equal parts, hand. The shoulder girdle of a foreleg is as long as each of the two parts.

    ground: height of the ground under a foreleg, None for an arm.
    """
    wrist = _wrist(limb, ground)
    if ground is not None and wrist > 2:
        _, shoulder, elbow = divided(limb.points, wrist, 3)
    else:
        shoulder, elbow = divided(limb.points, wrist, 2)
    return {
        "shoulder_girdle": limb.bones[:shoulder],
        "upper_arm": limb.bones[shoulder:elbow],
        "forearm": limb.bones[elbow:wrist],
        "hand": limb.bones[wrist : wrist + 1],
        "fingers": limb.bones[wrist + 1 : wrist + 2],
    }


def _wrist(limb: Limb, ground: float | None) -> int:
    """The index of the hand's bone: the first near the ground, the one with fingers, or the one that fits by length."""
    last = len(limb.bones)
    if ground is not None:
        floor = ground + GROUND_OF_HEIGHT * (limb.points[0].z - ground)
        return next((i for i, point in enumerate(limb.points[:-1]) if point.z < floor and i > 1), last - 1)
    with_fingers = [i for i, bone in enumerate(limb.bones) if len(bone.children) >= FEWEST_FINGERS and i > 1]
    if with_fingers:
        return with_fingers[0]
    least, most = (fraction * limb.length for fraction in HAND_OF_ARM)
    return next((i for i in range(2, last) if least < path_length(limb.points[i:]) < most), min(max(last - 1, 2), last))
