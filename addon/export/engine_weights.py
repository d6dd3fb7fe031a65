# SPDX-License-Identifier: GPL-3.0-or-later
"""The weights of a skin to its bones and to muscle bones together, and the vertex groups of its export copy."""

from dataclasses import dataclass

import _sinew
import numpy as np

from ..live.skin_cache import SkinState
from ..scene import rig_pose

# how much muscles have of a fit's first guess: nothing to speak of, but enough to be asked
_ASKED = 1e-3
# m, on a rig of 1.73 m: what a change by a whole weight has to bring
_HOLD_OF_RIG_SIZE = 0.003 / 1.73
_SMALLEST_SUM = 1e-4  # under which Blender does not move a vertex


@dataclass(frozen=True)
class MuscleFrames:
    """The muscles that are bones: (muscles,) their places in the musculature, and those of their bones in the copy's rest pose."""

    tissues: np.ndarray
    bones: np.ndarray


def of_bind(state: SkinState, copied: rig_pose.RigRest, muscles: MuscleFrames, most: int) -> tuple:
    """Each vertex weighed to muscles as it is bound to them, to its own bones by what is left; the `most` strongest of these.

    Returns offsets, bones and weights, as `_sinew.LinearSkin` takes them.
    """
    none = np.empty((0, len(copied.skeleton), 4, 4), np.float32), np.empty((0, len(state.points), 3), np.float32)
    return skin_of(state, copied, _mixed(state, copied, muscles, 1.0)).fit(*none, most, 0.0)


def fitted(
    state: SkinState, copied: rig_pose.RigRest, muscles: MuscleFrames, most: int, poses: np.ndarray, targets: np.ndarray
) -> tuple:
    """Each vertex weighed so that it comes nearest to `targets` in `poses`, by its own bones and the muscles that it is bound to.

    poses: (frames, bones, 4, 4) float32 column-major, of the copy. targets: (frames, vertices, 3) float32, mesh space.
    """
    start = skin_of(state, copied, _mixed(state, copied, muscles, _ASKED))
    return start.fit(poses, targets, most, _HOLD_OF_RIG_SIZE * copied.size)


def bare(state: SkinState, copied: rig_pose.RigRest) -> _sinew.LinearSkin:
    """The skin as its own bones alone carry it."""
    none = np.empty(0, np.intp)
    return skin_of(state, copied, _mixed(state, copied, MuscleFrames(none, none), 0.0))


def skin_of(state: SkinState, copied: rig_pose.RigRest, rows: tuple) -> _sinew.LinearSkin:
    """The export copy of a skin with these weights."""
    return _sinew.LinearSkin(copied.skeleton, state.points, state.mesh_to_armature, *rows)


def _mixed(state: SkinState, copied: rig_pose.RigRest, muscles: MuscleFrames, share: float) -> tuple:
    """The bind's weights to muscles, times `share`, and the mesh's own to bones by what they leave."""
    count = len(state.points)
    vertices = np.repeat(np.arange(count), np.diff(state.weights.offsets))
    sums = np.bincount(vertices, state.weights.weights, count)
    has_own = sums > _SMALLEST_SUM
    to_muscles = state.skin.tissue_weights[:, muscles.tissues] * np.where(has_own, share, 1.0)[:, None]
    kept = has_own[vertices]
    vertices, weights = vertices[kept], state.weights.weights[kept]
    weights = weights / sums[vertices] * (1.0 - to_muscles.sum(axis=1))[vertices]
    bones = _bones_in(state.rest, copied)[state.weights.bones[kept]]
    muscle_vertices, places = np.nonzero(to_muscles)
    return _rows(
        count,
        len(copied.skeleton),
        np.concatenate((vertices, muscle_vertices)),
        np.concatenate((bones, muscles.bones[places])),
        np.concatenate((weights, to_muscles[muscle_vertices, places])),
    )


def _bones_in(original: rig_pose.RigRest, copied: rig_pose.RigRest) -> np.ndarray:
    """(frames,) the copy's bone for each frame of the original; for the joints of a B-Bone, which no engine has, the bone."""
    found = np.full(len(original.skeleton), copied.armature_index, np.intp)
    for name, frame in original.index_of_bone.items():
        found[frame] = copied.index_of_bone[name]
    for bendy in original.bendy:
        found[bendy.first : bendy.first + bendy.segments + 1] = copied.index_of_bone[bendy.name]
    return found


def _rows(count: int, bone_count: int, vertices: np.ndarray, bones: np.ndarray, weights: np.ndarray) -> tuple:
    """Compressed rows of weights, one a vertex and bone."""
    places, of = np.unique(vertices * bone_count + bones, return_inverse=True)
    offsets = np.searchsorted(places, np.arange(count + 1) * bone_count)
    summed = np.bincount(of, weights, len(places))
    return offsets.astype(np.int32), (places % bone_count).astype(np.int32), summed.astype(np.float32)


def write(copy, copied: rig_pose.RigRest, rows: tuple):
    """Makes these weights the copy's vertex groups, in place of those of bones that it had."""
    offsets, bones, weights = rows
    names = {frame: name for name, frame in copied.index_of_bone.items()}
    for group in [group for group in copy.vertex_groups if group.name in copied.index_of_bone]:
        copy.vertex_groups.remove(group)
    vertices = np.repeat(np.arange(len(offsets) - 1), np.diff(offsets))
    for bone in np.unique(bones).tolist():
        group = copy.vertex_groups.new(name=names[bone])
        own = bones == bone
        for vertex, weight in zip(vertices[own].tolist(), weights[own].tolist(), strict=True):
            group.add((vertex,), weight, "REPLACE")
