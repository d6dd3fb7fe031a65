# SPDX-License-Identifier: GPL-3.0-or-later
"""The first tissue on a ray, in the pose of the last frame."""

from dataclasses import dataclass

import numpy as np

from . import ellipsoids
from .rig_cache import RigState


@dataclass(frozen=True)
class Hit:
    """tissue: index in `RigState.solved`. distance: from the start of the ray, in world space."""

    tissue: int
    distance: float


def first_hit(state: RigState, is_shown: list[bool], to_world, start, along) -> Hit | None:
    """The first ellipsoid on a ray, of the tissues that are shown, or None.

    is_shown: one per tissue of `state.solved`. to_world: the armature's matrix. start, along: point and direction in world
    space. Ellipsoids around the start are left out.
    """
    posed = ellipsoids.of(state)
    kept = np.array(is_shown, bool)[posed.owners]
    # the ray in the space of each unit sphere: |start + t along| = 1
    to_world_rows = np.array(to_world.transposed(), np.float64)
    to_units = np.linalg.inv(posed.matrices[kept].astype(np.float64) @ to_world_rows)
    starts = np.array((*start, 1.0)) @ to_units
    directions = np.array((*along, 0.0)) @ to_units
    a = np.einsum("ei,ei->e", directions[:, :3], directions[:, :3])
    b = np.einsum("ei,ei->e", starts[:, :3], directions[:, :3])
    c = np.einsum("ei,ei->e", starts[:, :3], starts[:, :3]) - 1.0
    under_root = b * b - a * c
    with np.errstate(invalid="ignore", divide="ignore"):
        enters = np.where(under_root >= 0.0, (-b - np.sqrt(under_root)) / a, np.inf)
    enters = np.where(enters > 0.0, enters, np.inf)
    if not len(enters) or not np.isfinite(enters.min()):
        return None
    first = int(enters.argmin())
    length = float(np.linalg.norm(np.array(along)))
    return Hit(int(posed.owners[kept][first]), float(enters[first]) * length)
