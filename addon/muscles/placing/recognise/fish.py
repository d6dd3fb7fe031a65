# SPDX-License-Identifier: GPL-3.0-or-later
"""The body of a fish: the chain of bones from its head to its tail, cut by length, and its first pair of fins."""

from collections.abc import Mapping
from dataclasses import dataclass

from bpy.types import Bone, Object
from mathutils import Vector

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


Line = tuple[tuple[Vector, ...], Vector, Vector]


@dataclass(frozen=True)
class Fish:
    """The bones of each part of a fish, and where the parts of its body run: where each bone starts, start and end."""

    chains: dict[BodyPart, tuple[str, ...]]
    lines: dict[BodyPart, Line]


def fish_of(rig: Object) -> Fish | None:
    """The parts of a fish's body. None if there is no chain of bones, or no pair of fins that tells left from right."""
    readings = readings_of(rig)
    bones = [bone for bone, reading in readings.items() if not reading.control]
    if len(bones) < FEWEST_BONES:
        return None
    space = body_space(rig, readings, bones)
    spine = _spine(rig, space, readings)
    fins = _fins(space, readings)
    if len(spine) < FEWEST_BONES or not fins:
        return None
    spine = _from_head(spine, fins[0], readings)
    first = _first_behind_head(spine, readings)
    parts = {"head": spine[:first][::-1]} | _cut(spine[first:])
    fronts, rears = _ends(spine)
    chains: dict[BodyPart, tuple[str, ...]] = {}
    lines: dict[BodyPart, Line] = {}
    for role, bones_of_part in parts.items():
        if not bones_of_part:
            continue
        starts, ends = (fronts, rears) if role in TAIL else (rears, fronts)
        chains[role, ""] = tuple(bone.name for bone in bones_of_part)
        lines[role, ""] = tuple(starts[bone] for bone in bones_of_part), starts[bones_of_part[0]], ends[bones_of_part[-1]]
    first_fin = min(fins, key=lambda fin: (fin[0].head_local - spine[0].head_local).length)
    for role, bone in zip(FIN_ROLES, first_fin, strict=False):
        chains[role, "L"], chains[role, "R"] = (bone.name,), (space.partners[bone].name,)
    return Fish(chains, lines)


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


def _spine(rig: Object, space: BodySpace, readings: Mapping[Bone, Reading]) -> list[Bone]:
    """The longest chain of bones in the middle of the body. It may turn at the bone that both halves hang from."""

    def central(bone: Bone) -> bool:
        said = readings[bone]
        return bone not in space.mirrored and not said.control and said.part != "fin" and not said.side

    best: list[Bone] = []
    for root in (bone for bone in rig.data.bones if central(bone) and (bone.parent is None or not central(bone.parent))):
        chain = [root, *longest_below(root, central)]
        for index, bone in enumerate(chain):
            if sum(map(central, bone.children)) < 2:
                best = max(best, chain, key=_length)
                continue
            taken = {*chain[: index + 2]}
            other = longest_below(bone, lambda child, taken=taken: central(child) and child not in taken)
            whole = [*reversed(other), *chain[index:]] if other else chain
            best = max(best, whole, key=_length)
    return best


def _length(bones: list[Bone]) -> float:
    return path_length([*(bone.head_local for bone in bones), *(bone.tail_local for bone in bones[-1:])])


def _fins(space: BodySpace, readings: Mapping[Bone, Reading]) -> list[list[Bone]]:
    """The chains of bones of the left fins, from the body outward."""
    roots = [bone for bone in space.partners if bone.parent is None or bone.parent not in space.partners]
    named = [bone for bone in roots if readings[bone].part == "fin"]
    chains = [[root, *longest_below(root, lambda child: child in space.partners)] for root in named or roots]
    longest = max(map(_length, chains), default=0.0)
    return [chain for chain in chains if _length(chain) > 0.3 * longest]


def _from_head(spine: list[Bone], fin: list[Bone], readings: Mapping[Bone, Reading]) -> list[Bone]:
    """The spine from the head backward: the head is where names say it, else nearer to the first pair of fins."""
    face = [index for index, bone in enumerate(spine) if readings[bone].part in FACE]
    tail = [index for index, bone in enumerate(spine) if readings[bone].part == "tail"]
    middle = (len(spine) - 1) / 2
    if face:
        is_last = sum(face) / len(face) > middle
    elif tail:
        is_last = sum(tail) / len(tail) < middle
    else:
        ends = [(bone.head_local - fin[0].head_local).length for bone in (spine[0], spine[-1])]
        is_last = ends[1] < ends[0]
    return spine[::-1] if is_last else spine


def _first_behind_head(spine: list[Bone], readings: Mapping[Bone, Reading]) -> int:
    """The index of the first bone behind the head. The head has at least one bone and leaves at least one."""
    heads = [index for index, bone in enumerate(spine) if readings[bone].part in ("head", "jaw")]
    if heads:
        return min(max(heads) + 1, len(spine) - 1)
    whole = _length(spine)
    return next((i for i in range(1, len(spine)) if _length(spine[: i + 1]) > HEAD_OF_LENGTH * whole), 1)


def _cut(body: list[Bone]) -> dict[str, list[Bone]]:
    """The bones of each part behind the head. Parts of the trunk are listed from the tail to the head, as in other
    bodies.
    """
    at = [(bone.head_local + bone.tail_local) / 2 for bone in body]
    along = [path_length(at[: index + 1]) for index in range(len(at))]
    whole = along[-1] or 1.0
    parts: dict[str, list[Bone]] = {role: [] for role in STARTS}
    for bone, distance in zip(body, along, strict=True):
        parts[[role for role, start in STARTS.items() if distance / whole >= start][-1]].append(bone)
    return {role: bones if role in TAIL else bones[::-1] for role, bones in parts.items()}
