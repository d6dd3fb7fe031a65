# SPDX-License-Identifier: GPL-3.0-or-later
"""Computes the pose of an export copy from the pose of its character: shared bones alike, muscle bones as the bellies.

It works on arrays of matrices and changes no Blender object. (`bake.scratch.scratch_rig` is another thing: a temporary
rig in the scene that Blender poses.)
"""

import numpy as np

from ..live.rig_cache import RigState
from ..scene import rig_pose
from .engine_weights import MuscleIndices
from .muscle_bones import MuscleBone


class CopyPose:
    """Converts poses of a rig to poses of its export copy.

    state: the rig's. copied: the rest pose of the copy, in which each of `muscles` has a bone. names: the solved
    tissues, in the order of the musculature.
    """

    def __init__(self, state: RigState, copied: rig_pose.RigRest, muscles: list[MuscleBone], names: list[str]):
        self.copied = copied
        self.indices = MuscleIndices(
            np.array([names.index(muscle.shape.name) for muscle in muscles], np.intp),
            np.array([copied.index_of_bone[muscle.bone] for muscle in muscles], np.intp),
        )
        self._state = state
        self._semi_axes = np.array([muscle.shape.semi_axes for muscle in muscles], np.float32).reshape(-1, 3)
        shared = [name for name in state.rest.index_of_bone if name in copied.index_of_bone]
        self._from = np.array([state.rest.index_of_bone[name] for name in shared], np.intp)
        self._to = np.array([copied.index_of_bone[name] for name in shared], np.intp)

    def matrices(self, pose: np.ndarray, tension: np.ndarray) -> np.ndarray:
        """Returns the copy's pose, (bones of the copy, 4, 4) float32, column-major. Helper bones stay at rest.

        pose: (bones of the rig, 4, 4) float32, column-major. tension: (tissues,) float32.
        """
        posed = np.empty_like(self._state.posed)
        self._state.musculature.pose(pose, tension, posed)
        bellies = posed[self.indices.tissues]
        copy_pose = np.tile(np.eye(4, dtype=np.float32), (len(self.copied.skeleton), 1, 1))
        copy_pose[self._to] = pose[self._from]
        # The axes X, Y and Z of a muscle bone are the axes x, z and -y of its belly.
        muscle_pose = np.empty_like(bellies)
        muscle_pose[:, 0] = bellies[:, 0] / self._semi_axes[:, 0, None]
        muscle_pose[:, 1] = bellies[:, 2] / self._semi_axes[:, 2, None]
        muscle_pose[:, 2] = -bellies[:, 1] / self._semi_axes[:, 1, None]
        muscle_pose[:, 3] = bellies[:, 3]
        copy_pose[self.indices.bones] = muscle_pose
        return copy_pose
