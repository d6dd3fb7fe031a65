# SPDX-License-Identifier: GPL-3.0-or-later
"""Via points under the skin: a path that bends around flesh must not leave it on the way.

A preset's via points come from another body. Where the belly along them would poke out, they are drawn toward the
straight line, which `fit` has made sure of; where little of the detour is left, the muscle is straight.
"""

import itertools
from dataclasses import replace

from mathutils import Vector

from ....scene.tissue_empty import TissueShape
from .skin_surface import SkinSurface

STATIONS = (-0.97, -0.85, -0.7, -0.5, -0.25, 0.0, 0.25, 0.5, 0.7, 0.85, 0.97)  # along the belly
DRAWN = 0.75  # how much of the detour stays at each step
STEPS = 8
ROUNDING = 1.35  # a path rounds its corners outward, and a belly that bends is wider across than along


def kept_inside(shape: TissueShape, skin: SkinSurface) -> TissueShape:
    """The muscle with via points between which its belly lies under the skin, or with none."""
    for _ in range(STEPS):
        if not shape.via_points or _lies_inside(shape, skin):
            return shape
        line = (shape.insertion - shape.origin).normalized()
        drawn = []
        for bone, point in shape.via_points:
            on_line = shape.origin + line * (point - shape.origin).dot(line)
            drawn.append((bone, on_line.lerp(point, DRAWN)))
        shape = replace(shape, via_points=tuple(drawn))
    return replace(shape, via_points=())


def _lies_inside(shape: TissueShape, skin: SkinSurface) -> bool:
    corners = [shape.origin, *(point for _, point in shape.via_points), shape.insertion]
    length_m = sum((there - here).length for here, there in itertools.pairwise(corners))
    belly_m = length_m - shape.origin_tendon - shape.insertion_tendon
    across_m = ROUNDING * max(shape.semi_axes.x, shape.semi_axes.y) + skin.margin_m
    for station in STATIONS:
        point = _along(corners, shape.origin_tendon + belly_m * (1 + station) / 2)
        if skin.nearest_distance(point) < across_m * (1 - station**2) ** 0.5 or not skin.is_inside(point):
            return False
    return True


def _along(corners: list[Vector], distance_m: float) -> Vector:
    for here, there in itertools.pairwise(corners):
        step_m = (there - here).length
        if distance_m <= step_m and step_m > 0.0:
            return here.lerp(there, distance_m / step_m)
        distance_m -= step_m
    return corners[-1]
