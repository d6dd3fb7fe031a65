# SPDX-License-Identifier: GPL-3.0-or-later
"""The body of a fish: the row of bones from its head to its tail, cut by length, and its first pair of fins."""

from collections.abc import Mapping
from dataclasses import dataclass

import _sinew
import numpy as np
from bpy.types import Bone, Object
from mathutils import Vector

from ....scene.skinned_bones import SkinnedBones
from .body_parts import BodyPart
from .body_space import BodySpace, body_space
from .limbs import longest_below, path_length
from .name_words import Reading
from .names import readings_of

FEWEST_BONES = 3  # along the body
# Where each part of the body starts, as a fraction of the length behind the head. A fish has no neck and no hips; the
# names are those of the preset's parts.
STARTS = {"chest": 0.0, "abdomen": 0.2, "pelvis": 0.36, "tail_base": 0.5, "tail_middle": 0.68, "tail_tip": 0.84}
HEAD_OF_LENGTH = 0.22  # of the whole fish, where no name tells the head
TAIL = ("tail_base", "tail_middle", "tail_tip")
FACE = ("head", "jaw", "neck")
FIN_ROLES = ("upper_arm", "forearm", "hand")
# A row of bones is the spine of a fish if it is this straight (distance of its ends over its length), this level (sine of
# its angle with the ground) and this long against the mesh. Coiled snakes, raised heads and necks are outside.
STRAIGHT, LEVEL_SINE, LONG_OF_MESH = 0.9, 0.35, 0.5

Line = tuple[tuple[Vector, ...], Vector, Vector]


@dataclass(frozen=True)
class Fish:
    """The bones of each part of a fish, and where the parts of its body run: where each bone starts, start and end.

    left: unit vector to the left of the body, in armature space.
    """

    chains: dict[BodyPart, tuple[str, ...]]
    lines: dict[BodyPart, Line]
    left: Vector


def has_level_spine(space: BodySpace, bones: list[Bone], readings: Mapping[Bone, Reading], points: np.ndarray) -> bool:
    """Whether a straight level row of bones in the middle runs through most of the body's length.

    points: (points, 3) of the skin, armature space; without any, the row is compared with the bones.
    """
    spine = _spine(bones, space, readings)
    if len(spine) < FEWEST_BONES:
        return False
    front, rear = space.head(spine[0]), space.head(spine[-1])
    length = path_length(space.head(bone) for bone in spine)
    if length <= 0.0:
        return False
    along = abs(front.y - rear.y)
    whole = float(np.ptp(points @ np.array(space.to_body[1][:3]))) if len(points) else space.size
    is_straight = (front - rear).length > STRAIGHT * length
    return is_straight and abs(front.z - rear.z) < LEVEL_SINE * length and along > LONG_OF_MESH * whole


def fish_of(rig: Object, skinned: SkinnedBones | None = None) -> Fish | None:
    """The parts of a fish's body. None if there is no row of bones in its middle.

    skinned: which skin the bones carry. Where neither names nor fins tell the head, it is at the end with the wider skin.
    """
    readings = readings_of(rig)
    bones = [bone for bone, reading in readings.items() if not reading.control]
    if len(bones) < FEWEST_BONES:
        return None
    space = body_space(rig, readings, bones)
    spine = _spine(bones, space, readings)
    fins = _fins(space, readings)
    if len(spine) < FEWEST_BONES:
        return None
    spine = _from_head(spine, fins[0] if fins else None, readings, space, skinned)
    first = _first_behind_head(spine, readings)
    fronts, rears = _ends(spine)
    parts = {"head": (spine[:first][::-1], rears[spine[first - 1]], fronts[spine[0]])} | _cut(spine[first:], fronts, rears)
    chains: dict[BodyPart, tuple[str, ...]] = {}
    lines: dict[BodyPart, Line] = {}
    for role, (bones_of_part, start, end) in parts.items():
        starts = fronts if role in TAIL else rears
        chains[role, ""] = tuple(bone.name for bone in bones_of_part)
        lines[role, ""] = tuple(starts[bone] for bone in bones_of_part), start, end
    first_fin = min(fins, key=lambda fin: (fin[0].head_local - spine[0].head_local).length, default=())
    for role, bone in zip(FIN_ROLES, first_fin, strict=False):
        chains[role, "L"], chains[role, "R"] = (bone.name,), (space.partners[bone].name,)
    return Fish(chains, lines, Vector(space.to_body[0][:3]).normalized())


def _ends(spine: list[Bone]) -> tuple[dict[Bone, Vector], dict[Bone, Vector]]:
    """The end of each bone towards the head, and towards the tail. Bones of a spine can point either way."""
    fronts: dict[Bone, Vector] = {}
    rears: dict[Bone, Vector] = {}
    for index, bone in enumerate(spine):
        ahead = spine[index - 1] if index else None
        behind = spine[index + 1] if index + 1 < len(spine) else None
        points_back = bone.parent == ahead if ahead is not None else behind is not None and behind.parent == bone
        if points_back or (ahead is not None and ahead.parent != bone):
            fronts[bone] = bone.head_local.copy()
            rears[bone] = behind.head_local.copy() if behind is not None else bone.tail_local.copy()
        else:
            rears[bone] = bone.head_local.copy()
            fronts[bone] = ahead.head_local.copy() if ahead is not None else bone.tail_local.copy()
    return fronts, rears


def _spine(bones: list[Bone], space: BodySpace, readings: Mapping[Bone, Reading]) -> list[Bone]:
    """The longest row of bones in the middle of the body. It may turn at the bone that both halves hang from."""

    def central(bone: Bone) -> bool:
        said = readings[bone]
        return bone not in space.mirrored and not said.control and said.part != "fin" and not said.side

    best: list[Bone] = []
    for root in (bone for bone in bones if central(bone) and (bone.parent is None or not central(bone.parent))):
        chain = [root, *longest_below(root, central)]
        for index, bone in enumerate(chain):
            if sum(map(central, bone.children)) < 2:
                best = max(best, chain, key=_length)
                continue
            taken = {*chain[: index + 2]}
            other = longest_below(bone, lambda child, taken=taken: central(child) and child not in taken)
            whole = [*reversed(other), *chain[index:]] if other else chain
            best = max(best, whole, key=_length)
    return _in_order(best)


def _in_order(row: list[Bone]) -> list[Bone]:
    """The row without the bones that are not between their neighbours, such as a root below the body."""
    if len(row) < 3:
        return row
    along = [bone.head_local.dot(row[-1].head_local - row[0].head_local) for bone in row]
    between = [before <= here <= after for before, here, after in zip(along, along[1:], along[2:], strict=False)]
    return [row[0], *(bone for bone, kept in zip(row[1:], between, strict=False) if kept), row[-1]]


def _length(bones: list[Bone]) -> float:
    return path_length([*(bone.head_local for bone in bones), *(bone.tail_local for bone in bones[-1:])])


def _fins(space: BodySpace, readings: Mapping[Bone, Reading]) -> list[list[Bone]]:
    """The chains of bones of the left fins, from the body outward."""
    roots = [bone for bone in space.partners if bone.parent is None or bone.parent not in space.partners]
    named = [bone for bone in roots if readings[bone].part == "fin"]
    chains = [[root, *longest_below(root, lambda child: child in space.partners)] for root in named or roots]
    longest = max(map(_length, chains), default=0.0)
    return [chain for chain in chains if _length(chain) > 0.3 * longest]


def _from_head(
    spine: list[Bone],
    fin: list[Bone] | None,
    readings: Mapping[Bone, Reading],
    space: BodySpace,
    skinned: SkinnedBones | None,
) -> list[Bone]:
    """The spine from the head backward. The head is where names say it, else nearer to the first pair of fins, else where
    the skin is wider: a tail fin is thin.
    """
    face = [index for index, bone in enumerate(spine) if readings[bone].part in FACE]
    tail = [index for index, bone in enumerate(spine) if readings[bone].part == "tail"]
    middle = (len(spine) - 1) / 2
    if face:
        is_last = sum(face) / len(face) > middle
    elif tail:
        is_last = sum(tail) / len(tail) < middle
    elif fin:
        ends = [(bone.head_local - fin[0].head_local).length for bone in (spine[0], spine[-1])]
        is_last = ends[1] < ends[0]
    else:
        widths = [_width(bone, space, skinned) for bone in (spine[0], spine[-1])]
        is_last = widths[1] > widths[0]
    return spine[::-1] if is_last else spine


def _width(bone: Bone, space: BodySpace, skinned: SkinnedBones | None) -> float:
    """How far the skin of a bone extends across the body; 0 without a skin."""
    points = skinned.points_of({bone.name}) if skinned is not None else ()
    return float(np.ptp(points @ np.array(space.to_body[0][:3]))) if len(points) else 0.0


def _first_behind_head(spine: list[Bone], readings: Mapping[Bone, Reading]) -> int:
    """The index of the first bone behind the head. The head has at least one bone and leaves at least one."""
    heads = [index for index, bone in enumerate(spine) if readings[bone].part in ("head", "jaw")]
    if heads:
        return min(max(heads) + 1, len(spine) - 1)
    whole = _length(spine)
    return next((i for i in range(1, len(spine)) if _length(spine[: i + 1]) > HEAD_OF_LENGTH * whole), 1)


def _cut(
    body: list[Bone], fronts: Mapping[Bone, Vector], rears: Mapping[Bone, Vector]
) -> dict[str, tuple[list[Bone], Vector, Vector]]:
    """The bones, the start and the end of each part behind the head.

    A bone that runs through several parts carries them all. Parts of the trunk run from the tail to the head.
    """
    points = [*(fronts[bone] for bone in body), rears[body[-1]]]
    along = [path_length(points[: index + 1]) for index in range(len(points))]
    path, whole = _sinew.Path(np.array(points, np.float64)), along[-1]
    parts = {}
    for (role, fraction), after in zip(STARTS.items(), (*list(STARTS.values())[1:], 1.0), strict=True):
        front_m, rear_m = fraction * whole, after * whole
        bones = [
            bone for bone, here, there in zip(body, along, along[1:], strict=False) if here < rear_m and there > front_m
        ]
        front, rear = (Vector(path.at(distance)) for distance in (front_m, rear_m))
        parts[role] = (bones, front, rear) if role in TAIL else (bones[::-1], rear, front)
    return {role: part for role, part in parts.items() if part[0]}
