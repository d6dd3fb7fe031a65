# SPDX-License-Identifier: GPL-3.0-or-later
"""The skin of a rig in its rest shape, in armature space. `_sinew.SkinSurface` computes; this hands it a mesh."""

from dataclasses import dataclass

import _sinew
import numpy as np
from bpy.types import Mesh, Object
from mathutils import Vector

from ....errors import SinewError
from ....scene import mesh_arrays


@dataclass(frozen=True)
class SkinSurface:
    """A rest mesh that can be asked where its skin is."""

    core: _sinew.SkinSurface

    @classmethod
    def of(cls, mesh_object: Object, rig: Object) -> "SkinSurface":
        """The rest shape (the basis, without modifiers) of a mesh, seen from its armature. Raises SinewError."""
        mesh: Mesh = mesh_object.data
        if mesh.is_editmode:
            raise SinewError(f"{mesh_object.name} is in Edit Mode: leave it (Tab) and try again")
        if len(mesh.polygons) == 0:
            raise SinewError(f"'{mesh_object.name}' has no faces, so there is no skin to fit muscles under")
        if abs(rig.matrix_world.determinant()) < 1e-12:
            raise SinewError(f"'{rig.name}' is scaled to nothing: give it a scale (Object Properties, Transform)")
        to_armature = rig.matrix_world.inverted() @ mesh_object.matrix_world
        if not np.isfinite(mesh_arrays.read_points(mesh)).all() or not np.isfinite(np.array(to_armature)).all():
            raise SinewError(f"'{mesh_object.name}' has vertices that are not finite numbers: repair the mesh first")
        return cls(_sinew.SkinSurface([mesh_arrays.read_polygons(mesh, to_armature)]))

    @property
    def size_m(self) -> float:
        """The longest side of the box around the skin, m."""
        return self.core.size

    @property
    def margin_m(self) -> float:
        """How far under the skin a belly ends: 1-2 mm on a person."""
        return self.core.margin

    def distance_along(self, origin: Vector, direction: Vector) -> float | None:
        """Distance to the skin from a point inside, m. 0 where the point is outside already, None where no skin is."""
        [distance] = self.core.distances_along(_row(origin), _row(direction.normalized())).tolist()
        return None if np.isnan(distance) else distance

    def is_inside(self, point: Vector) -> bool:
        """Whether the skin encloses a point."""
        return bool(self.core.are_inside(_row(point))[0])

    def toward_skin(self, point: Vector) -> Vector | None:
        """From a point inside to the nearest skin; None outside."""
        return Vector(self.core.nearest(_row(point))[0][0]) - point if self.is_inside(point) else None

    def nearest_distance(self, point: Vector) -> float:
        """Metres to the nearest skin, on either side of it."""
        return float(self.core.nearest(_row(point))[1][0])


def _row(vector: Vector) -> np.ndarray:
    return np.array([vector], np.float64)
