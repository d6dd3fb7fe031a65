# SPDX-License-Identifier: GPL-3.0-or-later
"""The joints of a rig as regions of its skin, and about what each is bent to try it."""

import math
from dataclasses import dataclass

import numpy as np
from mathutils import Matrix, Vector

from ..scene import bone_geometry, bone_weights, rig_pose

WEIGHING = 0.01
SHORT_SEGMENT = 0.8  # a segment shorter than this share of the next does not limit the joint: a pelvis, a shoulder girdle


@dataclass(frozen=True)
class Joint:
    """A joint at the head of a bone; lengths in the rig's space."""

    bone: str
    centre: Vector
    radius: float
    carried: np.ndarray  # (vertices,) bool: what the bone, all below it, or its parent weighs
    axis: Vector  # rest pose, in the rig's space
    bends_one_way: bool


def joints_of(skin, rig, rest: rig_pose.RigRest, musculature, bones: list[str] | None, axis: str) -> list[Joint]:
    """The joints of `bones`, or all that muscles cross but those inside a split or twist bone.

    axis: "MUSCLES" bends about the axis of the muscles' moments, and a bone without any about its own X; "X", "Y" and "Z"
    about that local axis. musculature: `_sinew.Musculature` or None.
    """
    turned = {}
    for frame, along, one_way in musculature.joints() if musculature else ():
        turned[frame] = Vector(along), one_way
    names = {frame: name for name, frame in rest.frame_of_bone.items()}
    if bones is None:
        bones = [names[frame] for frame in turned if not _is_split(rig, rest, names[frame])]
    weights = bone_weights.read_weights(skin, rest, rig.matrix_world.inverted_safe() @ skin.matrix_world)
    found = []
    for name in bones:
        if rig.data.bones[name].parent is None:
            continue
        own_axis, one_way = turned.get(rest.frame_of_bone[name], (bone_geometry.rest_axis(rig, name, 0), False))
        if axis != "MUSCLES":
            own_axis, one_way = bone_geometry.rest_axis(rig, name, "XYZ".index(axis)), False
        bone = rig.data.bones[name]
        found.append(
            Joint(
                name, bone.head_local.copy(), _radius(rig, rest, name), _carried(rig, rest, weights, name), own_axis, one_way
            )
        )
    return found


def turn(rig, joint: Joint, degrees: float):
    """Turns a joint from the rest pose about its axis; its bone's other channels are those of the rest pose."""
    own = rig.data.bones[joint.bone].matrix_local.to_3x3()
    rotation = Matrix.Rotation(math.radians(degrees), 3, joint.axis)
    rig.pose.bones[joint.bone].matrix_basis = (own.inverted() @ rotation @ own).to_4x4()


def turned_degrees(rig, evaluated_rig, name: str) -> float:
    """How far a bone is turned against its parent, from the rest pose."""
    bone, posed = rig.data.bones[name], evaluated_rig.pose.bones[name]
    rest = bone.parent.matrix_local.to_3x3().inverted() @ bone.matrix_local.to_3x3()
    now = posed.parent.matrix.to_3x3().inverted_safe() @ posed.matrix.to_3x3()
    return math.degrees((rest.inverted() @ now).to_quaternion().angle)


def _is_split(rig, rest: rig_pose.RigRest, name: str) -> bool:
    parent = rig.data.bones[name].parent
    return parent is not None and rest.segments[rest.frame_of_bone[name]] == rest.segments[rest.frame_of_bone[parent.name]]


def _radius(rig, rest: rig_pose.RigRest, name: str) -> float:
    """Half of the shorter of the two segments that meet at a joint."""
    parent = rig.data.bones[name].parent.name
    own, above = (_segment_length(rest, bone) for bone in (name, parent))
    return 0.5 * (own if _is_split(rig, rest, name) or above < SHORT_SEGMENT * own else min(own, above))


def _segment_length(rest: rig_pose.RigRest, name: str) -> float:
    return float(rest.lengths[rest.segments == rest.segments[rest.frame_of_bone[name]]].sum())


def _carried(rig, rest: rig_pose.RigRest, weights: bone_weights.BoneWeights, name: str) -> np.ndarray:
    bone = rig.data.bones[name]
    bones = {name, bone.parent.name, *(below.name for below in bone.children_recursive)}
    frames = {rest.frame_of_bone[found] for found in bones}
    for bendy in rest.bendy:
        if bendy.name in bones:
            frames.update(range(bendy.first, bendy.first + bendy.segments + 1))
    weighs = np.isin(weights.frames, list(frames)) & (weights.weights > WEIGHING)
    vertex_of_weight = np.repeat(np.arange(len(weights.offsets) - 1), np.diff(weights.offsets))
    carried = np.zeros(len(weights.offsets) - 1, bool)
    carried[vertex_of_weight[weighs]] = True
    return carried
