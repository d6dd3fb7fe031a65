# SPDX-License-Identifier: GPL-3.0-or-later
"""The only reader of bones: a rig's rest pose and its pose as the arrays that the core takes.

A *frame* here is a frame of reference that skin can be weighed to: one a bone, and for a B-Bone one more at each of its
joints. The last frame is the armature itself, which never moves: it stands for the part of a vertex that the vertex
group of an Armature modifier leaves in place.
"""

from mathutils import Matrix, Vector

from . import rig_pose


def has_bone(rig, name: str) -> bool:
    """Whether an object is a rig with a bone of this name."""
    return rig.type == "ARMATURE" and name in rig.data.bones


def bones_between(rig, first: str, second: str) -> list[str]:
    """The bones on the way from one bone to another through the hierarchy, both included; those two where there is none."""
    bones = rig.data.bones
    up, down = ([bones[name], *bones[name].parent_recursive] for name in (first, second))
    meeting = next((bone for bone in up if bone in down), None)
    if meeting is None:
        return [first, second]
    way = [*up[: up.index(meeting) + 1], *reversed(down[: down.index(meeting)])]
    return [bone.name for bone in way]


def bone_length(rig, name: str) -> float:
    """The rest length of a bone, which is how far from it Blender places its children; armature space."""
    return rig.data.bones[name].length


def rest_tail(rig, name: str) -> Matrix:
    """Where Blender places the children of a bone, in the rest pose: its axes, moved to its tail; armature space."""
    bone = rig.data.bones[name]
    return bone.matrix_local @ Matrix.Translation((0.0, bone.length, 0.0))


def in_bone(rig, name: str, point: Vector) -> Vector:
    """A point of armature space as a bone has it in the rest pose, in its own axes from its head."""
    return rig.data.bones[name].matrix_local.inverted() @ point


def selected_bones(rig) -> list[str]:
    """The selected bones of a rig; Blender 4.5 selects bones, 5.2 pose bones."""
    return [bone.name for bone in rig.pose.bones if (bone if hasattr(bone, "select") else bone.bone).select]


def bones_of_segment(rig, name: str) -> list[str]:
    """The bones that are one segment of the body with a bone, that one included: its split and twist bones."""
    rest = rig_pose.read_rest(rig)
    segment = rest.segments[rest.frame_of_bone[name]]
    return [bone for bone, frame in rest.frame_of_bone.items() if rest.segments[frame] == segment]


def point_along(rig, name: str, share: float):
    """The point at a share of a bone's length from its head, in the rest pose; armature space."""
    bone = rig.data.bones[name]
    return bone.head_local.lerp(bone.tail_local, share)


def rest_axis(rig, name: str, axis: int):
    """A bone's local axis (0 x, 1 y, 2 z) in the rest pose, unit length; armature space."""
    return rig.data.bones[name].matrix_local.col[axis].to_3d()


def lower_of(rig, first: str, second: str) -> str:
    """Of two bones the one that hangs on the other; `second` where neither does."""
    bones = rig.data.bones
    return first if bones[second] in bones[first].parent_recursive else second
