# SPDX-License-Identifier: GPL-3.0-or-later
"""The tendons of muscles in the current pose, as tubes between attachments and bellies."""

import numpy as np

WIDTH_OF_BELLY = 0.34  # of a tendon where it meets the belly
INTO_BELLY = 0.15  # of the half length: a tube ends inside the belly, where the belly is wider than the tube
SHORTEST_M = 1e-6


def straight(bellies: np.ndarray, attachments: np.ndarray, sign: float) -> np.ndarray:
    """(muscles, 4, 4) float32, column-major: tubes from attachments to the bellies of straight muscles.

    bellies: (muscles, 4, 4), column-major, from the unit sphere to each belly. attachments: (muscles, 3). sign: -1 for the
    origins, 1 for the insertions, which are on the side of the belly's local z.
    """
    tubes = np.zeros((len(bellies), 4, 4), np.float32)
    tubes[:, :2] = WIDTH_OF_BELLY * bellies[:, :2]
    belly_ends = bellies[:, 3, :3] + sign * (1.0 - INTO_BELLY) * bellies[:, 2, :3]
    tubes[:, 2, :3] = belly_ends - attachments
    tubes[:, 3, :3] = attachments
    tubes[:, 3, 3] = 1.0
    return tubes[np.linalg.norm(tubes[:, 2], axis=1) > SHORTEST_M]


def curved(points: np.ndarray, offsets: np.ndarray, bellies: np.ndarray, lengths_m: np.ndarray) -> np.ndarray:
    """(pieces, 4, 4) float32, column-major: tubes along the tendons of curved muscles, from one point of a path to the next.

    points, offsets: the paths, as from the core's `Musculature.path_points`. bellies: (paths, 4, 4), one per path.
    lengths_m: (paths, 2), the tendons at the origin and at the insertion.
    """
    counts = np.diff(offsets)
    path_of_point = np.repeat(np.arange(len(counts)), counts)
    starts = np.flatnonzero(path_of_point[:-1] == path_of_point[1:])
    along = points[starts + 1] - points[starts]
    piece_m = np.linalg.norm(along, axis=1)
    path = path_of_point[starts]
    until_m = np.cumsum(piece_m)
    path_end_m = until_m[np.cumsum(counts - 1) - 1]
    path_start_m = np.concatenate(([0.0], path_end_m[:-1]))
    hidden_m = INTO_BELLY * np.linalg.norm(bellies[:, 2, :3], axis=1)
    is_before_belly = until_m - piece_m < (path_start_m + lengths_m[:, 0] + hidden_m)[path]
    is_after_belly = until_m > (path_end_m - lengths_m[:, 1] - hidden_m)[path]
    kept = (is_before_belly | is_after_belly) & (piece_m > SHORTEST_M)
    starts, along, path = starts[kept], along[kept], path[kept]
    directions = along / piece_m[kept, None]
    radii = WIDTH_OF_BELLY * np.linalg.norm(bellies[:, :2, :3], axis=2).min(axis=1)
    tubes = np.zeros((len(starts), 4, 4), np.float32)
    tubes[:, 0, :3] = radii[path, None] * _across(directions)
    tubes[:, 1, :3] = np.cross(directions, tubes[:, 0, :3])
    tubes[:, 2, :3] = along
    tubes[:, 3, :3] = points[starts]
    tubes[:, 3, 3] = 1.0
    return tubes


def _across(directions: np.ndarray) -> np.ndarray:
    """(directions, 3): a unit vector across each unit vector."""
    smallest = np.eye(3, dtype=np.float32)[np.abs(directions).argmin(axis=1)]
    across = np.cross(directions, smallest)
    return across / np.linalg.norm(across, axis=1, keepdims=True)
