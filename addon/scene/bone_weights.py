# SPDX-License-Identifier: GPL-3.0-or-later
"""The only reader and writer of skin meshes: rest points, edges and weights in, the correction out. (What a person paints
for Sinew on them is for `painted_io`.)

The correction is a vector attribute that a Geometry Nodes modifier, first in the stack, adds to the points before the
Armature modifier. Nothing else of the mesh is touched.
"""

from dataclasses import dataclass

import numpy as np

from . import armature_modifier, rig_pose


@dataclass(frozen=True)
class BoneWeights:
    """A mesh's bone weights as the core takes them (CSR): see `_sinew.Skin`."""

    offsets: np.ndarray
    frames: np.ndarray
    weights: np.ndarray

    def __eq__(self, other) -> bool:
        return self is other or (
            np.array_equal(self.offsets, other.offsets)
            and np.array_equal(self.frames, other.frames)
            and np.array_equal(self.weights, other.weights)
        )


def read_weights(skin, rest: rig_pose.RigRest, mesh_to_armature) -> BoneWeights:
    """The weights of the bones that the Armature modifier of `skin` uses; none without such a modifier.

    A B-Bone's weight is shared between its two nearest joints and, where the modifier has a vertex group, a vertex's
    remainder goes to the armature itself, so that linear skinning of the frames is what Blender does.
    """
    modifiers = armature_modifier.armature_modifiers(skin)
    frame_of_group, bendy_of_group = {}, {}
    if modifiers and modifiers[0].use_vertex_groups:
        for group in skin.vertex_groups:
            if group.name in rest.deforming:
                frame_of_group[group.index] = rest.frame_of_bone[group.name]
                bendy = rest.bendy_bone(group.name)
                if bendy:
                    bendy_of_group[group.index] = bendy
    mask = skin.vertex_groups.get(modifiers[0].vertex_group) if modifiers else None
    mask_index = mask.index if mask else None
    inverted = bool(mask) and modifiers[0].invert_vertex_group
    pose_bones = armature_modifier.rig_of(skin).pose.bones if bendy_of_group else None

    offsets, frames, weights = [0], [], []
    for vertex in skin.data.vertices:
        first, share = len(frames), 0.0
        for element in vertex.groups:
            group, weight = element.group, element.weight
            if group == mask_index:
                share = weight
            if weight <= 0.0 or group not in frame_of_group:
                continue
            bendy = bendy_of_group.get(group)
            if bendy is None:
                frames.append(frame_of_group[group])
                weights.append(weight)
            else:
                joint, blend = pose_bones[bendy.name].bbone_segment_index(mesh_to_armature @ vertex.co)
                frames += (bendy.first + joint, bendy.first + joint + 1)
                weights += (weight * (1.0 - blend), weight * blend)
        if mask is not None:
            _mask(frames, weights, first, 1.0 - share if inverted else share, rest.armature_frame)
        offsets.append(len(frames))
    return BoneWeights(np.array(offsets, np.int32), np.array(frames, np.int32), np.array(weights, np.float32))


def _mask(frames: list, weights: list, first: int, share: float, armature_frame: int):
    total = sum(weights[first:])
    if total <= 0.0:
        return
    weights[first:] = [weight / total * share for weight in weights[first:]]
    frames.append(armature_frame)
    weights.append(1.0 - share)
