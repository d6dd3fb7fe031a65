# SPDX-License-Identifier: GPL-3.0-or-later
"""The rest pose in axes of the body: x to its left, y to its back, z up, with the plane of symmetry at x = 0.

Rigs come in any axes: Z up or Y up in armature space, facing -Y, X or Z. Left follows from the marks of left and right
in the names, else from the axis whose mirror images pair the most bones. Up follows from the object's transform.
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

from bpy.types import Bone, Object
from mathutils import Matrix, Vector
from mathutils.kdtree import KDTree

from .name_words import Reading

MIRROR_TOLERANCE_OF_SIZE = 0.01
NAMED_TOLERANCE_OF_SIZE = 0.1  # for bones whose names are equal but for the side
FAR_APART_OF_SIZE = 0.02  # mean distance of left from right bones, above which their names define left
NEARLY_AN_AXIS = 0.9  # cosine, 25 degrees: a direction this close to an axis of the armature is that axis
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

    def tail(self, bone: Bone) -> Vector:
        """The tail of a bone. The tails of imported bones have no meaning of their own."""
        return self.to_body @ bone.tail_local

    @property
    def mirrored(self) -> set[Bone]:
        """All bones that have a mirror image."""
        return set(self.partners) | set(self.partners.values())


def body_space(rig: Object, readings: Mapping[Bone, Reading], bones: list[Bone]) -> BodySpace:
    """The axes of a body. bones: those that count, at least one; controls can be anywhere."""
    ends = [point for bone in bones for point in (bone.head_local, bone.tail_local)]
    size = _extent(ends)
    up = _up(rig)
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
            found.append(BodySpace(to_body, size, _partners(bones, readings, to_body, size)))
    return max(found, key=lambda space: len(space.partners))


def _up(rig: Object) -> Vector:
    """The world's Z in armature space; an axis of the armature where it is close to one, which hides a tilt of the
    object.
    """
    turned = rig.matrix_world.to_3x3()
    if abs(turned.determinant()) < 1e-12:
        return _AXES[2].copy()
    up = (turned.inverted() @ _AXES[2]).normalized()
    return next(
        (axis * (1 if axis.dot(up) > 0 else -1) for axis in _AXES if abs(axis.dot(up)) > NEARLY_AN_AXIS),
        up if up.length > 0.5 else _AXES[2].copy(),
    )


def _left_by_names(readings: Mapping[Bone, Reading], bones: list[Bone], up: Vector, size: float) -> Vector | None:
    """The horizontal direction from the bones named as right to those named as left. None if the names do not tell."""
    heads = {side: [bone.head_local for bone in bones if readings[bone].side == side] for side in "LR"}
    if not heads["L"] or not heads["R"]:
        return None
    means = [sum(points, Vector()) / len(points) for points in heads.values()]
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


def _partners(bones: list[Bone], readings: Mapping[Bone, Reading], to_body: Matrix, size: float) -> dict[Bone, Bone]:
    """The bone on the right for each left bone that has one: of the same name, roughly mirrored; else exactly mirrored.

    Two bones mirror each other by position only if they are equally far from the root. The two ends of a tail do not.
    """
    depths = _depths(bones)
    ends = {bone: (to_body @ bone.head_local, to_body @ bone.tail_local) for bone in bones}
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
    tolerance = MIRROR_TOLERANCE_OF_SIZE * size
    right = [bone for bone in bones if bone not in taken and min(end.x for end in ends[bone]) < -tolerance]
    near = KDTree(len(right))
    for index, bone in enumerate(right):
        near.insert(ends[bone][0], index)
    near.balance()
    for bone in bones:
        if bone in taken or max(end.x for end in ends[bone]) <= tolerance:
            continue
        found = (
            right[index] for _point, index, _distance in sorted(near.find_range(images[bone][0], tolerance), key=_index)
        )
        for candidate in found:
            same_depth = depths[candidate] == depths[bone]
            if candidate not in taken and same_depth and (ends[candidate][1] - images[bone][1]).length < tolerance:
                partners[bone] = candidate
                taken |= {bone, candidate}
                break
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


def _index(found: tuple[Vector, int, float]) -> int:
    return found[1]


def _extent(points: Iterable[Vector]) -> float:
    points = list(points)
    return max(max(point[axis] for point in points) - min(point[axis] for point in points) for axis in range(3))
