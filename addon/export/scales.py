# SPDX-License-Identifier: GPL-3.0-or-later
"""Whether a transform keeps shapes, as game engines and most file formats expect of a skeleton."""

import numpy as np

_EVEN = 1e-4  # relative to the largest scale


def is_even(transform) -> bool:
    """Whether a transform (4, 4) rotates, moves and scales alike in all directions, without mirroring or shearing."""
    linear = np.array(transform, np.float64)[:3, :3]
    scale = np.linalg.norm(linear, 2)
    squared = linear.T @ linear
    return bool(np.abs(squared - scale**2 * np.eye(3)).max() <= _EVEN * scale**2 and np.linalg.det(linear) > 0.0)
