# SPDX-License-Identifier: GPL-3.0-or-later
"""How an export copy stands where its character stands: its own bones alike, its muscle bones as the bellies."""

import numpy as np

from ..live.rig_cache import RigState
from ..scene import rig_pose
from .engine_weights import MuscleFrames
from .muscle_bones import MuscleBone


class PosedCopy:
    """Carries poses of a rig over to its export copy.

    state: the rig's. copied: the rest pose of the copy, whose `muscles` are bones. names: of the tissues that are solved, in
    their order.
    """

    def __init__(self, state: RigState, copied: rig_pose.RigRest, muscles: list[MuscleBone], names: list[str]):
        self.copied = copied
        self.frames = MuscleFrames(
            np.array([names.index(muscle.shape.name) for muscle in muscles], np.intp),
            np.array([copied.index_of_bone[muscle.bone] for muscle in muscles], np.intp),
        )
        self._state = state
        self._semi_axes = np.array([muscle.shape.semi_axes for muscle in muscles], np.float32).reshape(-1, 3)
        shared = [name for name in state.rest.index_of_bone if name in copied.index_of_bone]
        self._from = np.array([state.rest.index_of_bone[name] for name in shared], np.intp)
        self._to = np.array([copied.index_of_bone[name] for name in shared], np.intp)

    def pose(self, pose: np.ndarray, tension: np.ndarray) -> np.ndarray:
        """(bones, 4, 4) float32, column-major: the copy's pose where the character's is `pose`; helpers stay at rest.

        pose: (frames, 4, 4), tension: (tissues,), as the core takes them.
        """
        posed = np.empty_like(self._state.posed)
        self._state.musculature.pose(pose, tension, posed)
        bellies = posed[self.frames.tissues]
        found = np.tile(np.eye(4, dtype=np.float32), (len(self.copied.skeleton), 1, 1))
        found[self._to] = pose[self._from]
        # a muscle bone's X, Y and Z are the belly's x, z and -y
        own = np.empty_like(bellies)
        own[:, 0] = bellies[:, 0] / self._semi_axes[:, 0, None]
        own[:, 1] = bellies[:, 2] / self._semi_axes[:, 2, None]
        own[:, 2] = -bellies[:, 1] / self._semi_axes[:, 1, None]
        own[:, 3] = bellies[:, 3]
        found[self.frames.bones] = own
        return found
