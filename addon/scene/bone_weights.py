# SPDX-License-Identifier: GPL-3.0-or-later
"""The bone weights of a mesh, as the core takes them."""

from dataclasses import dataclass

import numpy as np
from mathutils import Vector

from . import armature_modifier, rig_pose


@dataclass(frozen=True)
class BoneWeights:
    """The bone weights of a mesh: vertex v has the weights `offsets[v]` to `offsets[v + 1]` (see `_sinew.Skin`)."""

    offsets: np.ndarray  # (vertices + 1,) int32
    bones: np.ndarray  # (weights,) int32: indices into the skeleton of `rig_pose.RigRest`
    weights: np.ndarray  # (weights,) float32
    preserved_fractions: np.ndarray | None = None  # (vertices,) float32: see `read_preserved_fractions`

    def __eq__(self, other) -> bool:
        return self is other or (
            np.array_equal(self.offsets, other.offsets)
            and np.array_equal(self.bones, other.bones)
            and np.array_equal(self.weights, other.weights)
            and _are_same(self.preserved_fractions, other.preserved_fractions)
        )


def _are_same(one: np.ndarray | None, other: np.ndarray | None) -> bool:
    return one is other or (one is not None and other is not None and np.array_equal(one, other))


def read_weights(skin, values, rest: rig_pose.RigRest, mesh_to_armature, points: np.ndarray) -> BoneWeights:
    """The weights of the bones that the Armature modifier of `skin` uses. Without such a modifier there are none.

    values: the object that has the values of `skin` in an evaluation (`animated_value.values_of`), for the modifier's
    settings. mesh_to_armature: Matrix from mesh space to armature space. points: (vertices, 3), the rest points in mesh
    space.

    The weight of a B-Bone is divided between the two nearest joints of its segments. If the modifier has a vertex group,
    the rest of each vertex's weight goes to the armature. Linear skinning of these bones is then what Blender computes.
    """
    modifiers = armature_modifier.armature_modifiers(values)
    bone_of_group, bendy_of_group = {}, {}
    if modifiers and modifiers[0].use_vertex_groups:
        for group in skin.vertex_groups:
            if group.name in rest.deforming:
                bone_of_group[group.index] = rest.index_of_bone[group.name]
                bendy = rest.bendy_bone(group.name)
                if bendy:
                    bendy_of_group[group.index] = bendy
    # the modifier's vertex group is a mask: it says how much of each vertex follows the bones
    mask = skin.vertex_groups.get(modifiers[0].vertex_group) if modifiers else None
    mask_index = mask.index if mask else None
    inverted = bool(mask) and modifiers[0].invert_vertex_group
    pose_bones = armature_modifier.rig_of(skin).pose.bones if bendy_of_group else None

    offsets, bones, weights = [0], [], []
    for index, vertex in enumerate(skin.data.vertices):
        first, mask_weight = len(bones), 0.0
        for element in vertex.groups:
            group, weight = element.group, element.weight
            if group == mask_index:
                mask_weight = weight
            if weight <= 0.0 or group not in bone_of_group:
                continue
            bendy = bendy_of_group.get(group)
            if bendy is None:
                bones.append(bone_of_group[group])
                weights.append(weight)
            else:
                joint, blend = pose_bones[bendy.name].bbone_segment_index(mesh_to_armature @ Vector(points[index]))
                bones += (bendy.first + joint, bendy.first + joint + 1)
                weights += (weight * (1.0 - blend), weight * blend)
        if mask is not None:
            _mask(bones, weights, first, 1.0 - mask_weight if inverted else mask_weight, rest.armature_index)
        offsets.append(len(bones))
    return BoneWeights(
        np.array(offsets, np.int32),
        np.array(bones, np.int32),
        np.array(weights, np.float32),
        read_preserved_fractions(skin, values),
    )


def read_preserved_fractions(skin, values) -> np.ndarray | None:
    """(vertices,) float32: how much of each vertex two Armature modifiers move with Preserve Volume; the rest is linear.

    values: as for `read_weights`. None if the mesh has one Armature modifier, or two that do the same. In Blender the second
    has the weight of its vertex group, and the first the rest; without a vertex group the second alone counts.
    """
    second = armature_modifier.second_of_pair(values)
    if second is None:
        return None
    first_is = armature_modifier.skinning_of(values)
    if first_is == armature_modifier.skinning_of_second(values):
        return None
    by_second = np.ones(len(skin.data.vertices), np.float32)
    group = skin.vertex_groups.get(second.vertex_group)
    if group is not None:
        by_second[:] = 0.0
        for index, vertex in enumerate(skin.data.vertices):
            for element in vertex.groups:
                if element.group == group.index:
                    by_second[index] = element.weight
        if second.invert_vertex_group:
            by_second = 1.0 - by_second
    return by_second if first_is == "LINEAR" else 1.0 - by_second


def _mask(bones: list, weights: list, first: int, fraction: float, armature_index: int):
    """Scales the weights of a vertex, which begin at `first`, to this sum, and gives the rest to the armature."""
    total = sum(weights[first:])
    if total <= 0.0:
        return
    weights[first:] = [weight / total * fraction for weight in weights[first:]]
    bones.append(armature_index)
    weights.append(1.0 - fraction)
