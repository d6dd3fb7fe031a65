# SPDX-License-Identifier: GPL-3.0-or-later
"""Which meshes of a character are worn over others: a shirt over a body, a coat over it (docs/mathematics/garments.md)."""

from dataclasses import dataclass

import _sinew
import numpy as np
from bpy.types import Object

from ..errors import SinewError
from ..muscles.placing.fit.skin_surface import SkinSurface
from ..scene import armature_modifier, rest_body, stored_settings

SAMPLES = 200
NEAR_OF_SIZE = 0.04  # distance of a garment from the mesh under it, over that one's size: 7 cm on a person
MOST_NEAR, MOST_OUTSIDE = 0.6, 0.8  # fractions of a garment's vertices that are near a body, and outside of it
# A garment's longest side, over that of the mesh under it. Measured: the teeth of an animal have 0.09; they lie over its
# lips, whose motion tore them. A smaller garment, such as a glove, can be worn over a mesh by choice.
LEAST_OF_SIZE = 0.25
SAME_OF_SIZE = 1e-4  # a copy of a mesh is not worn over it


@dataclass(frozen=True)
class _Layer:
    """A mesh in the rest pose: its surface, and some of its vertices in armature space."""

    skin: Object
    surface: _sinew.SkinSurface
    points: np.ndarray


def under_each(rig, skins: list) -> dict:
    """The mesh that each of these meshes of a rig is worn over, by garment; meshes that are not worn over any are left out.

    A choice that was made before (Worn Over) is kept.
    """
    layers = [layer for layer in (_read(skin, rig) for skin in skins) if layer is not None]
    under = {
        layer.skin: stored_settings.worn_over_of(layer.skin) for layer in layers if armature_modifier.is_bound(layer.skin)
    }
    for layer in layers:
        if layer.skin in under:
            continue
        distances = [(_distance_over(layer, other), other.skin) for other in layers if other is not layer]
        near = sorted((distance, body.name, body) for distance, body in distances if distance is not None)
        under[layer.skin] = next((body for *_, body in near if not _is_under(body, layer.skin, under)), None)
    return {garment: body for garment, body in under.items() if body is not None}


def _read(skin, rig) -> _Layer | None:
    """A mesh as a layer; None if it has no surface."""
    if stored_settings.is_grown(skin):
        return None
    try:
        surface = SkinSurface.of(skin, rig).core
    except SinewError:
        return None  # Bind Skin says why such a mesh can't be bound
    to_armature = np.array(rig.matrix_world.inverted_safe() @ skin.matrix_world)
    points, shown = rest_body.read_points(skin), rest_body.shown_vertices(skin)
    points = points if shown is None else points[shown]
    points = points[:: max(len(points) // SAMPLES, 1)].astype(np.float64)
    return _Layer(skin, surface, np.ascontiguousarray(points @ to_armature[:3, :3].T + to_armature[:3, 3]))


def _distance_over(garment: _Layer, body: _Layer) -> float | None:
    """The median distance of a mesh from another one that it is worn over; None if it is not."""
    if np.ptp(garment.points, axis=0).max() < LEAST_OF_SIZE * body.surface.size:
        return None
    _points, distances = body.surface.nearest(garment.points)
    is_near = distances < NEAR_OF_SIZE * body.surface.size
    distance = float(np.median(distances))
    if is_near.mean() < MOST_NEAR or distance < SAME_OF_SIZE * body.surface.size:
        return None
    is_outside = ~np.asarray(body.surface.are_inside(garment.points), bool)
    return distance if is_outside[is_near].mean() >= MOST_OUTSIDE else None


def _is_under(body, garment, under: dict) -> bool:
    """Whether `body` is itself worn over `garment`, directly or through others."""
    for _ in range(len(under) + 1):
        if body is None or body == garment:
            break
        body = under.get(body)
    return body == garment
