# SPDX-License-Identifier: GPL-3.0-or-later
"""The rest pose in axes of the body: x to its left, y to its back, z up, with the plane of symmetry at x = 0.

Rigs come in any axes: Z up or Y up in armature space, facing -Y, X or Z. Left follows from the marks of left and right
in the names, else from the axis whose mirror images pair the most bones. Up follows from the object's transform; a body
whose legs are in line with its trunk by name, and that does not stand, lies: its trunk points up.

A bone ends where its children start, on average. The tails of imported bones have no meaning; only those of bones without
children are used.
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

import numpy as np
from bpy.types import Bone, Object
from mathutils import Matrix, Vector
from mathutils.kdtree import KDTree

from .name_words import OF_ARM, OF_FOOT, OF_LEG, Reading

MIRROR_TOLERANCE_OF_SIZE = 0.01
LARGEST_TOLERANCE_OF_SIZE = 0.04  # for a bone far from the middle, which no other bone can be mistaken for
TOLERANCE_OF_DISTANCE = 0.5  # the same, as a fraction of its distance from the middle
NAMED_TOLERANCE_OF_SIZE = 0.1  # for bones whose names are equal but for the side
FAR_APART_OF_SIZE = 0.02  # mean distance of left from right bones, above which their names define left
NEARLY_AN_AXIS = 0.9  # cosine, 25 degrees: a direction this close to an axis of the armature is that axis
IN_LINE = 0.8  # cosine, 37 degrees: legs this close to the direction of the trunk are in line with it
STANDING = 0.5  # cosine, 60 degrees, between the trunk and the vertical: a body in line that leans more lies
_AXES = tuple(Vector(axis) for axis in ((1, 0, 0), (0, 1, 0), (0, 0, 1)))


@dataclass(frozen=True)
class BodySpace:
    """Positions of bones in axes of the body, in units of armature space.

    to_body: from armature space. size: the largest extent of the bones. partners: the bone on the right that mirrors a bone
    on the left, by position.
    """

    to_body: Matrix
    size: float
    partners: Mapping[Bone, Bone]

    def head(self, bone: Bone) -> Vector:
        """The head of a bone."""
        return self.to_body @ bone.head_local

    def end(self, bone: Bone) -> Vector:
        """Where a bone ends."""
        return self.to_body @ end_of(bone)

    def heights(self, points: np.ndarray) -> np.ndarray:
        """(points,): the heights of (points, 3) points of armature space."""
        return points @ np.array(self.to_body[2][:3]) + self.to_body[2][3]

    @property
    def mirrored(self) -> set[Bone]:
        """All bones that have a mirror image."""
        return set(self.partners) | set(self.partners.values())


def end_of(bone: Bone) -> Vector:
    """Where a bone ends, in armature space: the mean of its children's heads; its tail if it has none."""
    heads = [child.head_local for child in bone.children]
    return sum(heads, Vector()) / len(heads) if heads else bone.tail_local


def body_space(rig: Object, readings: Mapping[Bone, Reading], bones: list[Bone]) -> BodySpace:
    """The axes of a body. bones: those that count, at least one; controls can be anywhere."""
    ends = [point for bone in bones for point in (bone.head_local, end_of(bone))]
    size = _extent(ends)
    up = _up(rig)
    up = _trunk_of_lying(readings, bones, up) or up
    named = _left_by_names(readings, bones, up, size)
    if named is not None:
        lefts = [named]
    else:
        lefts = [axis for axis in _AXES if abs(axis.dot(up)) < 1 - NEARLY_AN_AXIS]
        lefts = sorted(lefts, key=lambda axis: axis is not _AXES[0]) or [_perpendicular(up)]
    found = []
    for left in lefts:
        matrix = Matrix((left, up.cross(left), up)).to_4x4()
        middle = sum((matrix @ point for point in ends), Vector()).x / len(ends)
        for offset in dict.fromkeys((0.0, middle)):
            to_body = Matrix.Translation((-offset, 0, 0)) @ matrix
            exact = _partners(bones, readings, to_body, size, MIRROR_TOLERANCE_OF_SIZE)
            partners = _partners(bones, readings, to_body, size, LARGEST_TOLERANCE_OF_SIZE)
            found.append((len(exact), BodySpace(to_body, size, partners)))
    return max(found, key=lambda each: (each[0], len(each[1].partners)))[1]


def _up(rig: Object) -> Vector:
    """The world's Z in armature space; an axis of the armature where it is close to one, which hides a tilt of the
    object.
    """
    turned = rig.matrix_world.to_3x3()
    if abs(turned.determinant()) < 1e-12:
        return _AXES[2].copy()
    up = (turned.inverted() @ _AXES[2]).normalized()
    return _nearly_axis(up) or (up if up.length > 0.5 else _AXES[2].copy())


def _nearly_axis(direction: Vector) -> Vector | None:
    """The axis of the armature that a unit vector is close to, with its sign; None if there is none."""
    return next(
        (axis * (1 if axis.dot(direction) > 0 else -1) for axis in _AXES if abs(axis.dot(direction)) > NEARLY_AN_AXIS), None
    )


def _trunk_of_lying(readings: Mapping[Bone, Reading], bones: list[Bone], up: Vector) -> Vector | None:
    """The direction of the trunk, from the legs to the arms or the head, where legs and trunk are in line and not upright.

    None if the names tell no legs, if the legs are at an angle to the trunk, as those of animals are, or if it is upright.
    """
    said = {bone: readings[bone] for bone in bones if not readings[bone].other and not readings[bone].front}
    legs = {bone: None for bone, reading in said.items() if reading.side and reading.part in OF_LEG}
    named_feet = [bone for bone in legs if said[bone].part in OF_FOOT]
    hips = [bone.head_local for bone in legs if bone not in named_feet and bone.parent not in legs]  # a foot can hang apart
    lowest = named_feet or [bone for bone in legs if not any(child in legs for child in bone.children)]
    feet = [bone.head_local for bone in lowest]
    above = [
        bone.head_local
        for bone, reading in said.items()
        if reading.part in ("head", "neck") or (reading.side and reading.part in OF_ARM)
    ]
    if not hips or not above:
        return None
    middle = _mean(hips)
    trunk, along_legs = _mean(above) - middle, middle - _mean(feet)
    if trunk.length < 1e-9 or along_legs.length < 1e-9:
        return None
    trunk.normalize()
    if trunk.dot(along_legs.normalized()) < IN_LINE or trunk.dot(up) > STANDING:
        return None
    return _nearly_axis(trunk) or trunk


def _mean(points: list[Vector]) -> Vector:
    return sum(points, Vector()) / len(points)


def _left_by_names(readings: Mapping[Bone, Reading], bones: list[Bone], up: Vector, size: float) -> Vector | None:
    """The horizontal direction from the bones named as right to those named as left. None if the names do not tell."""
    heads = {side: [bone.head_local for bone in bones if readings[bone].side == side] for side in "LR"}
    if not heads["L"] or not heads["R"]:
        return None
    means = [_mean(points) for points in heads.values()]
    across = means[0] - means[1]
    across -= up * across.dot(up)
    if across.length < FAR_APART_OF_SIZE * size or across.length < 1e-9:
        return None
    across.normalize()
    for axis in _AXES:
        if abs(axis.dot(up)) < 1 - NEARLY_AN_AXIS and abs(axis.dot(across)) > NEARLY_AN_AXIS:
            return axis * (1 if axis.dot(across) > 0 else -1)
    return across


def _perpendicular(up: Vector) -> Vector:
    return min(_AXES, key=lambda axis: abs(axis.dot(up))).cross(up).normalized()


def _partners(
    bones: list[Bone], readings: Mapping[Bone, Reading], to_body: Matrix, size: float, largest_tolerance: float
) -> dict[Bone, Bone]:
    """The bone on the right for each left bone that has one: of the same name, roughly mirrored; else exactly mirrored.

    Two bones mirror each other by position only if they are equally far from the root. The two ends of a tail do not. Where
    a bone starts in the middle, its end must be mirrored, too; of several bones at one joint, the one whose parent mirrors
    the parent, and whose end is nearest, is taken. Rigs placed by eye are mirrored roughly: the farther a bone is from the
    middle, the less exactly, up to `largest_tolerance`, a fraction of the size. The axes of the body are those in which the
    most bones mirror each other exactly.
    """
    depths = _depths(bones)
    ends = {bone: (to_body @ bone.head_local, to_body @ end_of(bone)) for bone in bones}
    images = {bone: [Vector((-end.x, end.y, end.z)) for end in both] for bone, both in ends.items()}
    partners: dict[Bone, Bone] = {}
    named: dict[tuple[str, ...], list[Bone]] = {}
    for bone in bones:
        if readings[bone].side == "R":
            named.setdefault(readings[bone].rest, []).append(bone)
    for bone in bones:
        candidates = named.get(readings[bone].rest, ()) if readings[bone].side == "L" else ()
        if len(candidates) == 1 and (ends[candidates[0]][0] - images[bone][0]).length < NAMED_TOLERANCE_OF_SIZE * size:
            partners[bone] = candidates.pop()
    taken = {*partners, *partners.values()}
    least, most = MIRROR_TOLERANCE_OF_SIZE * size, largest_tolerance * size

    def tolerance(bone: Bone) -> float:
        nearest = min(abs(end.x) for end in ends[bone])
        return min(max(TOLERANCE_OF_DISTANCE * nearest, least), most)

    right = [bone for bone in bones if bone not in taken and min(end.x for end in ends[bone]) < -least]
    near = KDTree(len(right))
    for index, bone in enumerate(right):
        near.insert(ends[bone][0], index)
    near.balance()

    def difference(bone: Bone, candidate: Bone) -> tuple[bool, float]:
        is_same_parent = candidate.parent == partners.get(bone.parent, bone.parent)
        return not is_same_parent, (ends[candidate][1] - images[bone][1]).length

    for bone in sorted(bones, key=lambda bone: depths[bone]):
        if bone in taken or max(end.x for end in ends[bone]) <= least:
            continue
        found = [right[index] for _point, index, _distance in near.find_range(images[bone][0], tolerance(bone))]
        found = [each for each in found if each not in taken and depths[each] == depths[bone]]
        best = min(found, key=lambda each: (*difference(bone, each), each.name), default=None)
        if best is None:
            continue
        has_other_parent, apart = difference(bone, best)
        if apart < tolerance(bone) or (abs(ends[bone][0].x) > least and not has_other_parent):
            partners[bone] = best
            taken |= {bone, best}
    return partners


def _depths(bones: list[Bone]) -> dict[Bone, int]:
    """The number of bones above each bone."""
    depths: dict[Bone, int] = {}
    for bone in bones:
        path = [bone]
        while path[-1].parent is not None and path[-1] not in depths:
            path.append(path[-1].parent)
        depth = depths.get(path[-1], 0)
        for below, each in enumerate(reversed(path)):
            depths[each] = depth + below
    return depths


def _extent(points: Iterable[Vector]) -> float:
    points = list(points)
    return max(max(point[axis] for point in points) - min(point[axis] for point in points) for axis in range(3))
