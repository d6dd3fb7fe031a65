# SPDX-License-Identifier: GPL-3.0-or-later
"""The joints of a rig: the region of the skin around each joint, and the axis that it is rotated about."""

import math
from dataclasses import dataclass

import numpy as np
from mathutils import Matrix, Vector

from ..scene import bone_geometry, bone_weights, rest_body, rig_pose

SMALLEST_WEIGHT = 0.01  # bone weight above which a vertex belongs to a bone
# A parent segment shorter than this fraction of the joint's segment does not limit the region: a pelvis, a shoulder girdle.
SHORT_SEGMENT = 0.8


@dataclass(frozen=True)
class Joint:
    """A joint at the head of a bone. Points and lengths are in armature space, in the rest pose."""

    bone: str
    centre: Vector
    radius: float
    vertices: np.ndarray  # (vertices,) bool: those with a weight of the bone, of its parent or of a bone below it
    axis: Vector  # rotation axis
    bends_one_way: bool


def joints_of(skin, rig, rest: rig_pose.RigRest, musculature, bones: list[str] | None, axis: str) -> list[Joint]:
    """The joints of `bones`. None: the joints that muscles cross, except those between the parts of a split or twist bone.

    Bones without a parent are skipped. axis: "MUSCLES" uses the axis of the muscles' moments, or the bone's X if no muscle
    crosses the joint; "X", "Y" and "Z" use that local axis of the bone. musculature: `_sinew.Musculature` or None.
    """
    axis_of_bone = {}
    for index, direction, one_way in musculature.joints() if musculature else ():
        axis_of_bone[index] = Vector(direction), one_way
    names = {index: name for name, index in rest.index_of_bone.items()}
    if bones is None:
        bones = [names[index] for index in axis_of_bone if not _is_split(rig, rest, names[index])]
    to_armature = rig.matrix_world.inverted_safe() @ skin.matrix_world
    weights = bone_weights.read_weights(skin, skin, rest, to_armature, rest_body.read_points(skin))
    joints = []
    for name in bones:
        bone = rig.data.bones[name]
        if bone.parent is None:
            continue
        if axis == "MUSCLES":
            bone_x = bone_geometry.rest_axis(rig, name, 0), False
            direction, one_way = axis_of_bone.get(rest.index_of_bone[name], bone_x)
        else:
            direction, one_way = bone_geometry.rest_axis(rig, name, "XYZ".index(axis)), False
        joints.append(
            Joint(
                bone=name,
                centre=bone.head_local.copy(),
                radius=_radius(rig, rest, name),
                vertices=_vertices(rig, rest, weights, name),
                axis=direction,
                bends_one_way=one_way,
            )
        )
    return joints


def rotate(rig, joint: Joint, degrees: float):
    """Rotates a joint about its axis, from the rest pose. Replaces the location and scale of its bone."""
    bone_axes = rig.data.bones[joint.bone].matrix_local.to_3x3()
    rotation = Matrix.Rotation(math.radians(degrees), 3, joint.axis)
    rig.pose.bones[joint.bone].matrix_basis = (bone_axes.inverted() @ rotation @ bone_axes).to_4x4()


def rotation_degrees(rig, evaluated_rig, name: str) -> float:
    """The angle of a bone's rotation relative to its parent, from the rest pose."""
    bone, posed = rig.data.bones[name], evaluated_rig.pose.bones[name]
    rest = bone.parent.matrix_local.to_3x3().inverted() @ bone.matrix_local.to_3x3()
    now = posed.parent.matrix.to_3x3().inverted_safe() @ posed.matrix.to_3x3()
    return math.degrees((rest.inverted() @ now).to_quaternion().angle)


def _is_split(rig, rest: rig_pose.RigRest, name: str) -> bool:
    """Whether a bone and its parent are parts of one segment."""
    parent = rig.data.bones[name].parent
    return parent is not None and rest.segments[rest.index_of_bone[name]] == rest.segments[rest.index_of_bone[parent.name]]


def _radius(rig, rest: rig_pose.RigRest, name: str) -> float:
    """Half of the length of the shorter segment at a joint."""
    parent = rig.data.bones[name].parent.name
    below, above = (_segment_length(rest, bone) for bone in (name, parent))
    return 0.5 * (below if _is_split(rig, rest, name) or above < SHORT_SEGMENT * below else min(below, above))


def _segment_length(rest: rig_pose.RigRest, name: str) -> float:
    return float(rest.lengths[rest.segments == rest.segments[rest.index_of_bone[name]]].sum())


def _vertices(rig, rest: rig_pose.RigRest, weights: bone_weights.BoneWeights, name: str) -> np.ndarray:
    """(vertices,) bool: those with a weight of the bone, of its parent or of a bone below it."""
    bone = rig.data.bones[name]
    bones = {name, bone.parent.name, *(below.name for below in bone.children_recursive)}
    indices = {rest.index_of_bone[each] for each in bones}
    for bendy in rest.bendy:
        if bendy.name in bones:
            indices.update(range(bendy.first, bendy.first + bendy.segments + 1))
    counts = np.isin(weights.bones, list(indices)) & (weights.weights > SMALLEST_WEIGHT)
    vertex_of_weight = np.repeat(np.arange(len(weights.offsets) - 1), np.diff(weights.offsets))
    vertices = np.zeros(len(weights.offsets) - 1, bool)
    vertices[vertex_of_weight[counts]] = True
    return vertices
