# SPDX-License-Identifier: GPL-3.0-or-later
"""Bellies just under the skin: as thick as there is room, never poking out in the rest pose (ALGORITHM 9).

A belly is measured by rays from its own long axis, so the skin that counts is that of its own limb. What those rays
tell doesn't depend on the belly's widths; fitting a fitted belly therefore changes nothing.
"""

from dataclasses import replace

import numpy as np
from mathutils import Matrix, Vector

from ....scene.tissue_empty import TissueShape
from .detour import kept_inside
from .skin_surface import SkinSurface

COARSE = np.array((-0.97, -0.85, -0.6, -0.3, 0.0, 0.3, 0.6, 0.85, 0.97))  # along the axis; the belly's ends are -1, 1
FINE = np.array((-0.98, -0.94, -0.88, -0.8, -0.7, -0.55, -0.4, -0.2, 0.0, 0.2, 0.4, 0.55, 0.7, 0.8, 0.88, 0.94, 0.98))
ANGLES = np.arange(16) * (np.pi / 8)
END_STATION = 0.8

KEPT_WIDTH = 0.8  # a belly that would lose more width than this is first moved, or cut at its end
MOVES = 16
MOVE_OF_THICKNESS = 0.15
CUT_OF_BELLY = 0.08
LARGEST_MOVE_OF_BELLY = 0.5  # what lies farther outside isn't covered by this skin
GROWTH = 1.3  # a belly this near to the skin grows up to it; one with more room lies deep, and stays
UNCHANGED = 1e-4
TRIMS = 32
MIDDLE_STATION = 0.25
OUTSIDE_OF_MARGIN = 0.05
SAME_ROOM_M = 1e-4
MIRRORED_OF_SIZE = 1e-3
NEEDLE = 0.3  # a belly that would lose more than that of its width is cut instead


def fit_all(shapes: list[TissueShape], skin: SkinSurface) -> list[TissueShape]:
    """Each tissue fitted; the right of a symmetric body as the exact mirror image of the left."""
    fitted: dict[str, TissueShape] = {}
    placed = {shape.name: shape for shape in shapes}
    for shape in shapes:
        left = shape.name.removesuffix(".R") + ".L"
        image = _mirrored(fitted[left], shape) if left in fitted and _is_image(shape, placed[left]) else None
        if image is not None and _has_same_room(image, fitted[left], skin):
            fitted[shape.name] = image
        else:
            fitted[shape.name] = fit(shape, skin)
    return list(fitted.values())


def fit(shape: TissueShape, skin: SkinSurface) -> TissueShape:
    """The tissue with the widths that its place under the skin allows; as it is, where the mesh doesn't cover it."""
    if shape.kind == "SPHERE":
        return _sphere_inside(shape, skin)
    inside = _brought_inside(shape, skin)
    if inside is None:
        return shape
    moved, room = _moved_inside(inside, skin)
    return kept_inside(_trimmed(_filled(moved, room) if shape.kind == "MUSCLE" else moved, skin), skin)


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


def _flipped(vector: Vector) -> Vector:
    return Vector((-vector.x, vector.y, vector.z))


def _is_image(right: TissueShape, left: TissueShape) -> bool:
    """Whether two tissues were placed as mirror images: else something else than chance tells the sides apart."""
    apart_m = (_flipped(left.centre) - right.centre).length
    return max(apart_m, (left.semi_axes - right.semi_axes).length) < MIRRORED_OF_SIZE * right.semi_axes.z


def _mirrored(fitted: TissueShape, placed: TissueShape) -> TissueShape:
    """The mirror image of a fitted left tissue, on the right one's bones."""
    x, _, z = map(_flipped, _axes(fitted))
    return replace(
        fitted,
        name=placed.name,
        origin_bone=placed.origin_bone,
        insertion_bone=placed.insertion_bone,
        centre=_flipped(fitted.centre),
        rotation=Matrix((x, z.cross(x), z)).transposed().to_quaternion(),
        via_points=tuple(
            (bone, _flipped(point)) for (bone, _), (_, point) in zip(placed.via_points, fitted.via_points, strict=False)
        ),
        wraps=placed.wraps,
    )


def _has_same_room(image: TissueShape, left: TissueShape, skin: SkinSurface) -> bool:
    """Whether the skin is as far from both; an image's y axis looks the other way, so its angles run backward."""
    there = np.roll(_room(image, skin)[:, ::-1], 1, axis=1)
    return bool(np.allclose(there, _room(left, skin), rtol=0.0, atol=SAME_ROOM_M, equal_nan=True))


def _axes(shape: TissueShape) -> tuple[Vector, Vector, Vector]:
    columns = shape.rotation.to_matrix().transposed()
    return columns[0], columns[1], columns[2]


def _sphere_inside(shape: TissueShape, skin: SkinSurface) -> TissueShape:
    """A ball shrinks where the skin is nearer than it is large."""
    if not skin.is_inside(shape.centre):
        return shape
    room_m = max(skin.nearest_distance(shape.centre) - skin.margin_m, skin.margin_m)
    largest_m = max(shape.semi_axes)
    return shape if largest_m <= room_m else replace(shape, semi_axes=shape.semi_axes * (room_m / largest_m))


def _brought_inside(shape: TissueShape, skin: SkinSurface) -> TissueShape | None:
    """A straight line between two points in a bent body can run outside; such a belly is brought in, if it is near."""
    if skin.is_inside(shape.centre):
        return shape
    to_skin = skin.nearest(shape.centre) - shape.centre
    if to_skin.length > LARGEST_MOVE_OF_BELLY * shape.semi_axes.z:
        return None
    deeper = to_skin.normalized() * (min(shape.semi_axes.x, shape.semi_axes.y) + skin.margin_m)
    brought = replace(shape, centre=shape.centre + to_skin + deeper)
    return brought if skin.is_inside(brought.centre) else None


def _room(shape: TissueShape, skin: SkinSurface, stations: np.ndarray = COARSE, angles: np.ndarray = ANGLES) -> np.ndarray:
    """Metres from the long axis to just under the skin, by station and angle."""
    x, y, z = _axes(shape)
    spokes = [x * float(np.cos(angle)) + y * float(np.sin(angle)) for angle in angles]
    middles = [shape.centre + z * float(station * shape.semi_axes.z) for station in stations]
    to_skin_m = [[skin.distance_along(middle, spoke) for spoke in spokes] for middle in middles]
    # No skin at all is nan; where the axis itself is outside, there is next to none.
    return np.maximum(np.array(to_skin_m, dtype=float) - skin.margin_m, OUTSIDE_OF_MARGIN * skin.margin_m)


def _freedom(shape: TissueShape, room: np.ndarray, stations: np.ndarray = COARSE, angles: np.ndarray = ANGLES) -> np.ndarray:
    """By what factor the belly's widths could grow before it met the skin, by station and angle."""
    across = np.hypot(np.cos(angles) / shape.semi_axes.x, np.sin(angles) / shape.semi_axes.y)
    ribs = np.sqrt(1.0 - stations**2)  # how wide an ellipsoid is there
    return np.nan_to_num(room * across[None, :] / ribs[:, None], nan=np.inf)


def _moved_inside(shape: TissueShape, skin: SkinSurface) -> tuple[TissueShape, np.ndarray]:
    """Moved away from the skin, or cut at the end that it pokes out with, until little width has to go."""
    room = _room(shape, skin)
    for _ in range(MOVES):
        freedom = _freedom(shape, room)
        if freedom.min() >= KEPT_WIDTH:
            break
        tightest = COARSE[np.unravel_index(freedom.argmin(), freedom.shape)[0]]
        shape = _cut(shape, tightest) if abs(tightest) > END_STATION else _moved(shape, freedom, tightest, skin)
        room = _room(shape, skin)
    return shape, room


def _trimmed(shape: TissueShape, skin: SkinSurface) -> TissueShape:
    """What still pokes out between the coarse stations goes: from the widths where it is little, else from the end."""
    for _ in range(TRIMS):
        # evenly about the outline: a flat belly pokes out with its edges
        angles = np.arctan2(np.sin(ANGLES) * shape.semi_axes.y, np.cos(ANGLES) * shape.semi_axes.x)
        freedom = _freedom(shape, _room(shape, skin, FINE, angles), FINE, angles)
        least = float(freedom.min())
        if least >= 1.0 - UNCHANGED:
            break
        tightest = FINE[np.unravel_index(freedom.argmin(), freedom.shape)[0]]
        if least < NEEDLE and abs(tightest) > MIDDLE_STATION:
            shape = _cut(shape, tightest)
        elif least < NEEDLE:
            shape = _moved(shape, freedom, tightest, skin)
        else:
            widths = shape.semi_axes
            shape = replace(shape, semi_axes=Vector((widths.x * least, widths.y * least, widths.z)))
    return shape


def _cut(shape: TissueShape, station: float) -> TissueShape:
    """The belly ends sooner there and the tendon takes over; origin and insertion stay."""
    cut_m = CUT_OF_BELLY * 2 * shape.semi_axes.z
    sign = 1.0 if station > 0 else -1.0
    widths = shape.semi_axes
    cut = replace(
        shape,
        centre=shape.centre - _axes(shape)[2] * (sign * cut_m / 2),
        semi_axes=Vector((widths.x, widths.y, widths.z - cut_m / 2)),
    )
    if shape.kind != "MUSCLE":
        return cut
    return replace(
        cut,
        origin_tendon=shape.origin_tendon + (cut_m if sign < 0 else 0.0),
        insertion_tendon=shape.insertion_tendon + (cut_m if sign > 0 else 0.0),
    )


def _moved(shape: TissueShape, freedom: np.ndarray, tightest: float, skin: SkinSurface) -> TissueShape:
    """A step away from where the belly pokes out; as far as the skin, where its very axis is outside."""
    x, y, z = _axes(shape)
    thickness_m = min(shape.semi_axes.x, shape.semi_axes.y)
    middle = shape.centre + z * float(tightest * shape.semi_axes.z)
    if not skin.is_inside(middle):
        inward = skin.nearest(middle) - middle
        inward -= z * inward.dot(z)
        return replace(shape, centre=shape.centre + inward + inward.normalized() * (thickness_m + skin.margin_m))
    lack = np.clip(1.0 - freedom, 0.0, 1.0).sum(axis=0)
    away = x * float(-(lack * np.cos(ANGLES)).sum()) + y * float(-(lack * np.sin(ANGLES)).sum())
    return replace(shape, centre=shape.centre + away.normalized() * (MOVE_OF_THICKNESS * thickness_m))


def _filled(shape: TissueShape, room: np.ndarray) -> TissueShape:
    """Widths scaled to just under the skin where it is near; then the thickness alone, where only the edges touch."""
    factor = float(_freedom(shape, room).min())
    if factor > GROWTH or factor < NEEDLE:
        return shape  # with room to spare, or to be cut
    if abs(factor - 1.0) > UNCHANGED:
        widths = shape.semi_axes
        shape = replace(shape, semi_axes=Vector((widths.x * factor, widths.y * factor, widths.z)))
    thickest_m = _thickest(shape, room)
    if shape.semi_axes.x * (1 + UNCHANGED) < thickest_m <= GROWTH * shape.semi_axes.x:
        shape = replace(shape, semi_axes=Vector((thickest_m, shape.semi_axes.y, shape.semi_axes.z)))
    return shape


def _thickest(shape: TissueShape, room: np.ndarray) -> float:
    """The largest x semi-axis that fits, at the y semi-axis that the belly has."""
    sideways = (1.0 - COARSE[:, None] ** 2) - (room * np.sin(ANGLES) / shape.semi_axes.y) ** 2
    outward = room * np.abs(np.cos(ANGLES))
    binding = (sideways > 1e-9) & (outward > 1e-9)
    if not binding.any():
        return np.inf
    return float((outward[binding] / np.sqrt(sideways[binding])).min())
