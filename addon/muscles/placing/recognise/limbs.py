# SPDX-License-Identifier: GPL-3.0-or-later
"""The limbs of a body by symmetry and hierarchy: chains of bones in left-right pairs that branch off its middle."""

import itertools
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass

from bpy.types import Bone
from mathutils import Vector

from .body_space import BodySpace
from .name_words import Reading

SHORTEST_LIMB_OF_SIZE = 0.15  # of the larger of a body's height and length, because wings can be much longer than both
FEWEST_LIMB_BONES = 2
MOST_JOINTS_TRIED = 30  # of a limb with more joints, every second, third, ... is tried as a knee
UNUSED_COST = 0.5  # cost of the unused length of a limb, against the difference between the lengths of its parts
MIDDLE_OF_LIMB = 0.01  # fraction of a limb's length within which a joint is in the middle of the body


@dataclass(frozen=True)
class Limb:
    """A left limb: its bones from the body outward, their joints and its end in body axes, and the bone it branches off."""

    bones: tuple[Bone, ...]
    points: tuple[Vector, ...]
    parent: Bone | None

    @property
    def length(self) -> float:
        """The length along its bones."""
        return path_length(self.points)

    @property
    def lowest(self) -> float:
        """The height of its lowest joint."""
        return min(point.z for point in self.points)


def limbs_of(
    space: BodySpace, bones: Iterable[Bone], readings: Mapping[Bone, Reading], without: tuple[str, ...]
) -> list[Limb]:
    """The left limbs that have a mirror image, are long enough and have at least two bones. Hair and cloth are not limbs.

    without: parts whose chains are not limbs, by name.
    """
    heads = [space.head(bone) for bone in bones]
    size = max(max(point[axis] for point in heads) - min(point[axis] for point in heads) for axis in (1, 2))
    roots = [bone for bone in space.partners if bone.parent is None or bone.parent not in space.partners]
    roots = [bone for bone in roots if not readings[bone].other and readings[bone].part not in without]
    limbs = [_limb(bone, space) for bone in roots]
    return [limb for limb in limbs if limb.length > SHORTEST_LIMB_OF_SIZE * size and len(limb.bones) >= FEWEST_LIMB_BONES]


def _limb(root: Bone, space: BodySpace) -> Limb:
    bones = (root, *longest_below(root, lambda child: child in space.partners))
    return Limb(bones, (*(space.head(bone) for bone in bones), space.end(bones[-1])), root.parent)


def longest_below(root: Bone, belongs: Callable[[Bone], bool]) -> list[Bone]:
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


def path_length(points: Iterable[Vector]) -> float:
    """The length of a polyline."""
    return sum((there - here).length for here, there in itertools.pairwise(points))


def divided(points: tuple[Vector, ...], last: int, parts: int) -> tuple[int, ...]:
    """Indices of the joints that divide a limb up to point `last` into parts of similar length, and use most of its length.

    A limb does not start in the middle of the body: a bone from the middle to the first joint is not part of it.
    """
    whole_m = path_length(points[: last + 1]) or 1.0
    first = next((i for i in range(max(last - parts, 0)) if points[i].x > MIDDLE_OF_LIMB * whole_m), max(last - parts, 0))

    def cost(cuts: tuple[int, ...]) -> float:
        lengths = [(points[there] - points[here]).length for here, there in itertools.pairwise((*cuts, last))]
        return (max(lengths) - min(lengths) + UNUSED_COST * path_length(points[: cuts[0] + 1])) / whole_m

    joints = range(first, last, 1 + (last - first) // MOST_JOINTS_TRIED)
    choices = itertools.combinations(joints, min(parts, last))
    best = min(choices, key=cost)
    return best if len(best) == parts else (*best, *[last] * (parts - len(best)))
