# SPDX-License-Identifier: GPL-3.0-or-later
"""Fits tissues under the skin in the rest pose: a belly fills the clearance and never protrudes.

Converts tissues to arrays for `_sinew.SkinSurface.fit` and back (docs/mathematics/fitting.md, Fit under the skin).
"""

from dataclasses import replace

import _sinew
import numpy as np
from mathutils import Quaternion, Vector

from ....scene.tissue_empty import TissueShape
from .skin_surface import SkinSurface


def fit_all(shapes: list[TissueShape], skin: SkinSurface) -> list[TissueShape]:
    """All tissues, fitted. On a symmetric body the right side is the exact mirror image of the left."""
    return _updated(shapes, skin.core.fit(_placed(shapes), _left_twins(shapes)))


def fill_all(shapes: list[TissueShape], skin: SkinSurface, volumes_m3: list[float], fat_m: list[float]) -> list[TissueShape]:
    """All fitted tissues, grown into the room that the body leaves (docs/mathematics/fitting.md, Fill).

    volumes_m3: the volume that each should have; 0 for as much as there is room. fat_m: the depth of fat over each.
    """
    volumes, fat = np.array(volumes_m3, np.float64), np.array(fat_m, np.float64)
    return _updated(shapes, skin.core.fill(_placed(shapes), volumes, fat, _left_twins(shapes)))


def _updated(shapes: list[TissueShape], fitted: _sinew.PlacedTissues) -> list[TissueShape]:
    """The tissues with what the core changed."""
    offsets, points = fitted.via_offsets.tolist(), fitted.via_points
    rows = zip(shapes, fitted.centres, fitted.rotations, fitted.semi_axes, fitted.tendons.tolist(), strict=True)
    return [
        replace(
            shape,
            centre=Vector(centre),
            rotation=Quaternion(rotation),
            semi_axes=Vector(semi_axes),
            origin_tendon=origin_tendon,
            insertion_tendon=insertion_tendon,
            # a path keeps all of its via points or none
            via_points=tuple(
                (bone, Vector(point))
                for (bone, _), point in zip(shape.via_points, points[offsets[i] : offsets[i + 1]], strict=False)
            ),
        )
        for i, (shape, centre, rotation, semi_axes, (origin_tendon, insertion_tendon)) in enumerate(rows)
    ]


def fit(shape: TissueShape, skin: SkinSurface) -> TissueShape:
    """The tissue, sized to fit under the skin; unchanged where the skin does not cover it."""
    return fit_all([shape], skin)[0]


def protrusion(shape: TissueShape, skin: SkinSurface) -> float:
    """The distance by which the tissue protrudes from the skin, m; 0 if it does not. Sampled more finely than in `fit`."""
    return float(skin.core.protrusions(_placed([shape]))[0])


def _placed(shapes: list[TissueShape]) -> _sinew.PlacedTissues:
    counts = [len(shape.via_points) for shape in shapes]
    points = [point for shape in shapes for _bone, point in shape.via_points]
    return _sinew.PlacedTissues(
        kinds=[shape.kind for shape in shapes],
        centres=_rows([shape.centre for shape in shapes], 3),
        rotations=_rows([shape.rotation for shape in shapes], 4),
        semi_axes=_rows([shape.semi_axes for shape in shapes], 3),
        tendons=_rows([(shape.origin_tendon, shape.insertion_tendon) for shape in shapes], 2),
        via_offsets=np.cumsum([0, *counts], dtype=np.int32),
        via_points=_rows(points, 3),
    )


def _rows(vectors: list, width: int) -> np.ndarray:
    return np.array(vectors, np.float64).reshape(-1, width)


def _left_twins(shapes: list[TissueShape]) -> np.ndarray:
    """(tissues,) int32: for each tissue `name.R` the index of `name.L`; otherwise -1."""
    indices = {shape.name: index for index, shape in enumerate(shapes)}
    twins = (indices.get(shape.name[:-2] + ".L", -1) if shape.name.endswith(".R") else -1 for shape in shapes)
    return np.fromiter(twins, np.int32, len(shapes))
