# SPDX-License-Identifier: GPL-3.0-or-later
"""The ellipsoids of a rig's tissues in the pose of the current frame, with their stretch."""

from dataclasses import dataclass

import numpy as np

from .rig_cache import RigState


@dataclass(frozen=True)
class Ellipsoids:
    """matrices: (ellipsoids, 4, 4) float32, column-major, from the unit sphere to each ellipsoid in armature space.

    stretch: (ellipsoids,), 1 at rest. owners: (ellipsoids,), the index of each one's tissue in `RigState.solved`.
    """

    matrices: np.ndarray
    stretch: np.ndarray
    owners: np.ndarray


def of(state: RigState) -> Ellipsoids:
    """Poses the tissues. Also fills `state.posed`."""
    stretch = state.musculature.pose(state.pose, state.tension, state.posed).stretch
    owners = state.musculature.ellipsoid_tissue
    matrices = np.empty((len(owners), 4, 4), np.float32)
    state.musculature.pose_ellipsoids(state.pose, state.tension, matrices)
    return Ellipsoids(matrices, stretch[owners], owners)
