# SPDX-License-Identifier: GPL-3.0-or-later
"""Bellies just under the skin: as thick as there is room, never poking out in the rest pose.

`_sinew.SkinSurface.fit` computes (rust/core/src/fit; docs/mathematics/fitting.md). This hands it tissues as arrays and takes
them back.
"""

from dataclasses import replace

import _sinew
import numpy as np
from mathutils import Quaternion, Vector

from ....scene.tissue_empty import TissueShape
from .skin_surface import SkinSurface


def fit_all(shapes: list[TissueShape], skin: SkinSurface) -> list[TissueShape]:
    """Each tissue fitted; the right of a symmetric body as the exact mirror image of the left."""
    fitted = skin.core.fit(_placed(shapes), _lefts(shapes))
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
    """The tissue with the widths that its place under the skin allows; as it is, where the mesh doesn't cover it."""
    return fit_all([shape], skin)[0]


def protrusion(shape: TissueShape, skin: SkinSurface) -> float:
    """How far the tissue pokes out of the skin, in metres; 0 where it doesn't. Sampled finer than `fit` samples."""
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


def _lefts(shapes: list[TissueShape]) -> np.ndarray:
    """(tissues,) int32: of each tissue on the right its namesake on the left, else -1."""
    places = {shape.name: place for place, shape in enumerate(shapes)}
    lefts = (places.get(shape.name[:-2] + ".L", -1) if shape.name.endswith(".R") else -1 for shape in shapes)
    return np.fromiter(lefts, np.int32, len(shapes))
