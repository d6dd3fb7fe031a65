# SPDX-License-Identifier: GPL-3.0-or-later
"""Bellies just under the skin: as thick as there is room, never poking out in the rest pose (ALGORITHM 9).

A belly is measured by rays from its own long axis, so the skin that counts is that of its own limb. What those rays
tell doesn't depend on the belly's widths; fitting a fitted belly therefore changes nothing.
"""

from dataclasses import replace

import numpy as np
from mathutils import Vector

from ..tissue_io import RIGID_KINDS, TissueShape
from .skin_surface import SkinSurface

STATIONS = np.array((-0.97, -0.85, -0.6, -0.3, 0.0, 0.3, 0.6, 0.85, 0.97))  # along the axis; the belly's ends are -1, 1
RIBS = np.sqrt(1.0 - STATIONS**2)  # how wide an ellipsoid is there
ANGLES = np.arange(16) * (np.pi / 8)
END_STATION = 0.8

KEPT_WIDTH = 0.8  # a belly that would lose more width than this is first moved, or cut at its end
MOVES = 12
MOVE_OF_THICKNESS = 0.15
CUT_OF_BELLY = 0.08
GROWTH = 1.3  # a belly this near to the skin grows up to it; one with more room lies deep, and stays
UNCHANGED = 1e-4


def fit(shape: TissueShape, skin: SkinSurface) -> TissueShape:
    """The tissue with the widths that its place under the skin allows; as it is, where the mesh doesn't cover it."""
    if shape.kind in RIGID_KINDS:
        return _rigid_inside(shape, skin)
    moved, room = _moved_inside(shape, skin)
    return _filled(moved, room) if skin.is_inside(moved.centre) else shape


def protrusion(shape: TissueShape, skin: SkinSurface) -> float:
    """How far the tissue pokes out of the skin, in metres; 0 where it doesn't. Sampled finer than `fit` samples."""
    farthest_m = 0.0
    x, y, z = _axes(shape)
    for station in np.linspace(-0.98, 0.98, 25):
        middle = shape.centre + z * float(station * shape.semi_axes.z)
        rib = float(np.sqrt(1.0 - station**2))
        for angle in np.linspace(0.0, 2.0 * np.pi, 32, endpoint=False):
            spoke = x * (float(np.cos(angle)) * shape.semi_axes.x) + y * (float(np.sin(angle)) * shape.semi_axes.y)
            spoke *= rib
            to_skin_m = skin.distance_along(middle, spoke.normalized())
            if to_skin_m is not None and to_skin_m < spoke.length:
                farthest_m = max(farthest_m, skin.nearest_distance(middle + spoke))
    return farthest_m


def _axes(shape: TissueShape) -> tuple[Vector, Vector, Vector]:
    columns = shape.rotation.to_matrix().transposed()
    return columns[0], columns[1], columns[2]


def _rigid_inside(shape: TissueShape, skin: SkinSurface) -> TissueShape:
    """A rigid tissue keeps its proportions, and shrinks where the skin is nearer than it is large."""
    if not skin.is_inside(shape.centre):
        return shape
    room_m = max(skin.nearest_distance(shape.centre) - skin.margin_m, skin.margin_m)
    largest_m = max(shape.semi_axes)
    return shape if largest_m <= room_m else replace(shape, semi_axes=shape.semi_axes * (room_m / largest_m))


def _room(shape: TissueShape, skin: SkinSurface) -> np.ndarray:
    """Metres from the long axis to just under the skin, by station and angle."""
    x, y, z = _axes(shape)
    spokes = [x * float(np.cos(angle)) + y * float(np.sin(angle)) for angle in ANGLES]
    middles = [shape.centre + z * float(station * shape.semi_axes.z) for station in STATIONS]
    to_skin_m = [[skin.distance_along(middle, spoke) for spoke in spokes] for middle in middles]
    # No skin at all is nan; an axis that is itself outside leaves a needle.
    return np.maximum(np.array(to_skin_m, dtype=float) - skin.margin_m, skin.margin_m)


def _freedom(shape: TissueShape, room: np.ndarray) -> np.ndarray:
    """By what factor the belly's widths could grow before it met the skin, by station and angle."""
    across = np.hypot(np.cos(ANGLES) / shape.semi_axes.x, np.sin(ANGLES) / shape.semi_axes.y)
    return np.nan_to_num(room * across[None, :] / RIBS[:, None], nan=np.inf)


def _moved_inside(shape: TissueShape, skin: SkinSurface) -> tuple[TissueShape, np.ndarray]:
    """Moved away from the skin, or cut at the end that it pokes out with, until little width has to go."""
    room = _room(shape, skin)
    for _ in range(MOVES):
        freedom = _freedom(shape, room)
        if freedom.min() >= KEPT_WIDTH:
            break
        tightest = STATIONS[np.unravel_index(freedom.argmin(), freedom.shape)[0]]
        shape = _cut(shape, tightest) if abs(tightest) > END_STATION else _moved(shape, freedom)
        room = _room(shape, skin)
    return shape, room


def _cut(shape: TissueShape, station: float) -> TissueShape:
    """The belly ends sooner there and the tendon takes over; origin and insertion stay."""
    cut_m = CUT_OF_BELLY * 2 * shape.semi_axes.z
    sign = 1.0 if station > 0 else -1.0
    widths = shape.semi_axes
    return replace(
        shape,
        centre=shape.centre - _axes(shape)[2] * (sign * cut_m / 2),
        semi_axes=Vector((widths.x, widths.y, widths.z - cut_m / 2)),
        origin_tendon=shape.origin_tendon + (cut_m if sign < 0 else 0.0),
        insertion_tendon=shape.insertion_tendon + (cut_m if sign > 0 else 0.0),
    )


def _moved(shape: TissueShape, freedom: np.ndarray) -> TissueShape:
    """A step away from where the belly pokes out."""
    x, y, _ = _axes(shape)
    lack = np.clip(1.0 - freedom, 0.0, 1.0).sum(axis=0)
    away = x * float(-(lack * np.cos(ANGLES)).sum()) + y * float(-(lack * np.sin(ANGLES)).sum())
    step_m = MOVE_OF_THICKNESS * min(shape.semi_axes.x, shape.semi_axes.y)
    return replace(shape, centre=shape.centre + away.normalized() * step_m)


def _filled(shape: TissueShape, room: np.ndarray) -> TissueShape:
    """Widths scaled to just under the skin where it is near; then the thickness alone, where only the edges touch."""
    factor = float(_freedom(shape, room).min())
    if factor > GROWTH:
        return shape
    if abs(factor - 1.0) > UNCHANGED:
        widths = shape.semi_axes
        shape = replace(shape, semi_axes=Vector((widths.x * factor, widths.y * factor, widths.z)))
    thickest_m = _thickest(shape, room)
    if shape.semi_axes.x * (1 + UNCHANGED) < thickest_m <= GROWTH * shape.semi_axes.x:
        shape = replace(shape, semi_axes=Vector((thickest_m, shape.semi_axes.y, shape.semi_axes.z)))
    return shape


def _thickest(shape: TissueShape, room: np.ndarray) -> float:
    """The largest x semi-axis that fits, at the y semi-axis that the belly has."""
    sideways = RIBS[:, None] ** 2 - (room * np.sin(ANGLES) / shape.semi_axes.y) ** 2
    outward = room * np.abs(np.cos(ANGLES))
    binding = (sideways > 1e-9) & (outward > 1e-9)
    if not binding.any():
        return np.inf
    return float((outward[binding] / np.sqrt(sideways[binding])).min())
