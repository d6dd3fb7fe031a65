# SPDX-License-Identifier: GPL-3.0-or-later
"""Weights of a skin for its bones and muscle bones together, and the vertex groups of its export copy.

The fit is described in docs/mathematics/baking.md, Weights for engines.
"""

from dataclasses import dataclass

import _sinew
import numpy as np

from ..live.skin_cache import SkinState
from ..scene import rig_pose

# The weight of muscles in the start of a fit: negligible, but above 0, since a fit only considers bones that have a weight.
_START_WEIGHT = 1e-3
# A weight changes by 1 only if that brings the vertex closer by more than this; m, on a rig of 1.73 m.
_HOLD_OF_RIG_SIZE = 0.003 / 1.73
_SMALLEST_SUM = 1e-4  # Blender does not move vertices with a smaller sum of weights

# offsets, bones and weights, as `_sinew.LinearSkin` takes them
WeightRows = tuple[np.ndarray, np.ndarray, np.ndarray]


@dataclass(frozen=True)
class MuscleIndices:
    """The indices, (muscles,), of muscles in the musculature and of their bones in the rest pose of the export copy."""

    tissues: np.ndarray
    bones: np.ndarray


def of_bind(state: SkinState, copied: rig_pose.RigRest, muscles: MuscleIndices, most: int) -> WeightRows:
    """Returns the bind's weights for muscles, and the mesh's weights for bones scaled to the rest; the `most` largest."""
    none = np.empty((0, len(copied.skeleton), 4, 4), np.float32), np.empty((0, len(state.points), 3), np.float32)
    return skin_of(state, copied, _mixed(state, copied, muscles, 1.0)).fit(*none, most, 0.0)


def fitted(
    state: SkinState, copied: rig_pose.RigRest, muscles: MuscleIndices, most: int, poses: np.ndarray, targets: np.ndarray
) -> WeightRows:
    """Returns the weights with which linear skinning comes closest to `targets` in `poses` (Le and Deng 2012).

    A vertex gets weights for its bones and for the muscles that it is bound to, `most` at most. poses: (frames, bones, 4, 4)
    float32, column-major, of the copy. targets: (frames, vertices, 3) float32, mesh space.
    """
    start = skin_of(state, copied, _mixed(state, copied, muscles, _START_WEIGHT))
    return start.fit(poses, targets, most, _HOLD_OF_RIG_SIZE * copied.size)


def without_muscles(state: SkinState, copied: rig_pose.RigRest) -> _sinew.LinearSkin:
    """Returns the skin with the mesh's weights for bones alone."""
    none = np.empty(0, np.intp)
    return skin_of(state, copied, _mixed(state, copied, MuscleIndices(none, none), 0.0))


def skin_of(state: SkinState, copied: rig_pose.RigRest, rows: WeightRows) -> _sinew.LinearSkin:
    """Returns the linear skin of the export copy with these weights."""
    return _sinew.LinearSkin(copied.skeleton, state.points, state.mesh_to_armature, *rows)


def _mixed(state: SkinState, copied: rig_pose.RigRest, muscles: MuscleIndices, factor: float) -> WeightRows:
    """Returns the bind's weights for muscles times a factor, and the mesh's weights for bones scaled to the rest.

    Vertices without bone weights are moved by muscles alone, so the factor does not apply to them.
    """
    count = len(state.points)
    vertices = np.repeat(np.arange(count), np.diff(state.weights.offsets))
    sums = np.bincount(vertices, state.weights.weights, count)
    has_bones = sums > _SMALLEST_SUM
    to_muscles = state.skin.tissue_weights[:, muscles.tissues] * np.where(has_bones, factor, 1.0)[:, None]
    kept = has_bones[vertices]
    vertices, weights = vertices[kept], state.weights.weights[kept]
    weights = weights / sums[vertices] * (1.0 - to_muscles.sum(axis=1))[vertices]
    bones = _bones_in(state.rest, copied)[state.weights.bones[kept]]
    muscle_vertices, columns = np.nonzero(to_muscles)
    return _rows(
        count,
        len(copied.skeleton),
        np.concatenate((vertices, muscle_vertices)),
        np.concatenate((bones, muscles.bones[columns])),
        np.concatenate((weights, to_muscles[muscle_vertices, columns])),
    )


def _bones_in(original: rig_pose.RigRest, copied: rig_pose.RigRest) -> np.ndarray:
    """Returns the copy's bone for each bone of the original. The joints of a B-Bone, which engines lack, become its bone."""
    bones = np.full(len(original.skeleton), copied.armature_index, np.intp)
    for name, index in original.index_of_bone.items():
        bones[index] = copied.index_of_bone[name]
    for bendy in original.bendy:
        bones[bendy.first : bendy.first + bendy.segments + 1] = copied.index_of_bone[bendy.name]
    return bones


def _rows(count: int, bone_count: int, vertices: np.ndarray, bones: np.ndarray, weights: np.ndarray) -> WeightRows:
    """Returns compressed rows with one weight per vertex and bone; weights of the same vertex and bone are summed."""
    cells, cell_of_weight = np.unique(vertices * bone_count + bones, return_inverse=True)
    offsets = np.searchsorted(cells, np.arange(count + 1) * bone_count)
    summed = np.bincount(cell_of_weight, weights, len(cells))
    return offsets.astype(np.int32), (cells % bone_count).astype(np.int32), summed.astype(np.float32)


def write(copy, copied: rig_pose.RigRest, rows: WeightRows):
    """Replaces the copy's vertex groups of bones by groups with these weights."""
    offsets, bones, weights = rows
    names = {index: name for name, index in copied.index_of_bone.items()}
    for group in [group for group in copy.vertex_groups if group.name in copied.index_of_bone]:
        copy.vertex_groups.remove(group)
    vertices = np.repeat(np.arange(len(offsets) - 1), np.diff(offsets))
    for bone in np.unique(bones).tolist():
        group = copy.vertex_groups.new(name=names[bone])
        of_bone = bones == bone
        for vertex, weight in zip(vertices[of_bone].tolist(), weights[of_bone].tolist(), strict=True):
            group.add((vertex,), weight, "REPLACE")
