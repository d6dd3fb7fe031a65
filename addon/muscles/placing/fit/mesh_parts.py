# SPDX-License-Identifier: GPL-3.0-or-later
"""A closed mesh as several ellipsoids: a scanned bone becomes rigid tissues (Wilhelms 1997, future work).

The inside of the mesh is divided into as many parts as there should be ellipsoids by k-means from the points farthest apart
(Gonzalez 1985; Lloyd 1982). Each part becomes the ellipsoid with its second moments, and all grow to fill the mesh
(docs/mathematics/fitting.md, Fill).
"""

import numpy as np
from mathutils import Matrix, Vector

from ....errors import SinewError
from ....scene.tissue_empty import TissueShape
from . import fit
from .skin_surface import SkinSurface

POINTS_ALONG = 40  # points of the grid along the longest side of the mesh
ROUNDS = 12
FEWEST_POINTS = 8  # of a part


def ellipsoids(surface: SkinSurface, points: np.ndarray, count: int, name: str, bone: str) -> list[TissueShape]:
    """Up to `count` pieces of stuffing on a bone that fill a mesh. points: (V, 3), its vertices, armature space, m.

    Raises SinewError if the mesh encloses nothing.
    """
    inside = _inside(surface, points)
    if len(inside) < FEWEST_POINTS:
        raise SinewError(f"'{name}' encloses no volume: close its holes, or give it a thickness")
    parts = [part for part in _parts(inside, count) if len(part) >= FEWEST_POINTS]
    shapes = [_shape(part, f"{name} {number + 1}", bone) for number, part in enumerate(parts)]
    zeros = [0.0] * len(shapes)
    return fit.fill_all(shapes, surface, zeros, zeros)


def _inside(surface: SkinSurface, points: np.ndarray) -> np.ndarray:
    low, high = points.min(0), points.max(0)
    spacing = (high - low).max() / POINTS_ALONG
    axes = [np.arange(start + spacing / 2, end, spacing) for start, end in zip(low, high)]
    grid = np.stack(np.meshgrid(*axes, indexing="ij"), -1).reshape(-1, 3)
    return grid[surface.core.are_inside(grid)]


def _parts(points: np.ndarray, count: int) -> list[np.ndarray]:
    centres = [points[np.argmax(np.linalg.norm(points - points.mean(0), axis=1))]]
    nearest = np.linalg.norm(points - centres[0], axis=1)
    while len(centres) < min(count, len(points)):
        centres.append(points[np.argmax(nearest)])
        nearest = np.minimum(nearest, np.linalg.norm(points - centres[-1], axis=1))
    centres = np.array(centres)
    for _ in range(ROUNDS):
        owners = np.argmin(np.linalg.norm(points[:, None] - centres, axis=2), axis=1)
        centres = np.array([points[owners == i].mean(0) if (owners == i).any() else c for i, c in enumerate(centres)])
    return [points[owners == index] for index in range(len(centres))]


def _shape(part: np.ndarray, name: str, bone: str) -> TissueShape:
    centre = part.mean(0)
    variances, axes = np.linalg.eigh(np.cov((part - centre).T))  # ascending, so that z is the longest
    if np.linalg.det(axes) < 0:
        axes[:, 0] *= -1
    semi_axes = np.sqrt(5 * np.maximum(variances, 1e-12))
    return TissueShape(
        name=name,
        kind="STUFFING",
        origin_bone=bone,
        insertion_bone=bone,
        centre=Vector(centre),
        rotation=Matrix(axes.tolist()).to_quaternion(),
        semi_axes=Vector(semi_axes),
    )
