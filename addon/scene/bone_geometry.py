# SPDX-License-Identifier: GPL-3.0-or-later
"""Positions, axes and neighbours of single bones in the rest pose."""

from mathutils import Matrix, Vector

from . import rig_pose


def has_bone(rig, name: str) -> bool:
    """Whether an object is a rig with a bone of this name."""
    return rig.type == "ARMATURE" and name in rig.data.bones


def bones_between(rig, first: str, second: str) -> list[str]:
    """The bones on the path from one bone to another through the hierarchy, including both.

    Only the two bones if no path connects them.
    """
    bones = rig.data.bones
    up, down = ([bones[name], *bones[name].parent_recursive] for name in (first, second))
    ancestor = next((bone for bone in up if bone in down), None)
    if ancestor is None:
        return [first, second]
    path = [*up[: up.index(ancestor) + 1], *reversed(down[: down.index(ancestor)])]
    return [bone.name for bone in path]


def bone_length(rig, name: str) -> float:
    """The rest length of a bone, in armature space."""
    return rig.data.bones[name].length


def rest_tail(rig, name: str) -> Matrix:
    """The axes of a bone at its tail, in the rest pose; armature space. Blender places objects with a parent bone there."""
    bone = rig.data.bones[name]
    return bone.matrix_local @ Matrix.Translation((0.0, bone.length, 0.0))


def in_bone(rig, name: str, point: Vector) -> Vector:
    """A point of armature space in the axes of a bone, from its head, in the rest pose."""
    return rig.data.bones[name].matrix_local.inverted() @ point


def selected_bones(rig) -> list[str]:
    """The names of the selected bones. Blender 4.5 stores the selection in bones, 5.2 in pose bones."""
    return [bone.name for bone in rig.pose.bones if (bone if hasattr(bone, "select") else bone.bone).select]


def bones_of_segment(rig, name: str) -> list[str]:
    """The bones of the segment of the body that a bone is part of, such as an arm bone with its twist bones."""
    rest = rig_pose.read_rest(rig)
    segment = rest.segments[rest.index_of_bone[name]]
    return [bone for bone, index in rest.index_of_bone.items() if rest.segments[index] == segment]


def point_along(rig, name: str, fraction: float):
    """The point at a fraction of a bone's length from its head, in the rest pose; armature space."""
    bone = rig.data.bones[name]
    return bone.head_local.lerp(bone.tail_local, fraction)


def rest_axis(rig, name: str, axis: int):
    """A bone's local axis (0 x, 1 y, 2 z) in the rest pose, unit length; armature space."""
    return rig.data.bones[name].matrix_local.col[axis].to_3d()


def lower_of(rig, first: str, second: str) -> str:
    """The one of two bones that is a descendant of the other. `second` if neither is."""
    bones = rig.data.bones
    return first if bones[second] in bones[first].parent_recursive else second
