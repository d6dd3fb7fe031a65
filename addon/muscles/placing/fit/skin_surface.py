# SPDX-License-Identifier: GPL-3.0-or-later
"""The skin of a rig in the rest pose, in armature space: converts a mesh and vectors for `_sinew.SkinSurface`."""

from dataclasses import dataclass

import _sinew
import numpy as np
from bpy.types import Mesh, Object
from mathutils import Vector

from ....errors import SinewError
from ....scene import mesh_arrays


@dataclass(frozen=True)
class SkinSurface:
    """A mesh in the rest pose, for rays, inside tests and nearest points."""

    core: _sinew.SkinSurface

    @classmethod
    def of(cls, mesh_object: Object, rig: Object) -> "SkinSurface":
        """The surface of one mesh (see `of_all`)."""
        return cls.of_all([mesh_object], rig)

    @classmethod
    def of_all(cls, mesh_objects: list[Object], rig: Object) -> "SkinSurface":
        """The basis shapes of meshes, without modifiers, in the armature space of `rig`. Raises SinewError."""
        for mesh_object in mesh_objects:
            mesh: Mesh = mesh_object.data
            if mesh.is_editmode:
                raise SinewError(f"{mesh_object.name} is in Edit Mode: leave it (Tab) and try again")
            if len(mesh.polygons) == 0:
                raise SinewError(f"'{mesh_object.name}' has no faces, so there is no skin to fit muscles under")
        if abs(rig.matrix_world.determinant()) < 1e-12:
            raise SinewError(f"'{rig.name}' is scaled to nothing: give it a scale (Object Properties, Transform)")
        return cls(_sinew.SkinSurface([_polygons(mesh_object, rig) for mesh_object in mesh_objects]))

    @property
    def size_m(self) -> float:
        """The longest side of the box around the skin, m."""
        return self.core.size

    @property
    def margin_m(self) -> float:
        """Margin between a fitted belly and the skin, m: 1-2 mm on a person."""
        return self.core.margin

    def distance_along(self, origin: Vector, direction: Vector) -> float | None:
        """Distance from a point inside to the skin, m. 0 if the point is outside, None if the ray does not hit the skin."""
        [distance] = self.core.distances_along(_row(origin), _row(direction.normalized())).tolist()
        return None if np.isnan(distance) else distance

    def is_inside(self, point: Vector) -> bool:
        """Whether the skin encloses a point."""
        return bool(self.core.are_inside(_row(point))[0])

    def toward_skin(self, point: Vector) -> Vector | None:
        """The vector from a point inside to the nearest point of the skin, m; None if the point is outside."""
        return Vector(self.core.nearest(_row(point))[0][0]) - point if self.is_inside(point) else None

    def nearest_distance(self, point: Vector) -> float:
        """The distance to the skin of a point inside or outside, m."""
        return float(self.core.nearest(_row(point))[1][0])


def _polygons(mesh_object: Object, rig: Object) -> _sinew.PolygonMesh:
    to_armature = rig.matrix_world.inverted() @ mesh_object.matrix_world
    if not np.isfinite(mesh_arrays.read_points(mesh_object.data)).all() or not np.isfinite(np.array(to_armature)).all():
        raise SinewError(f"'{mesh_object.name}' has vertices that are not finite numbers: repair the mesh first")
    return mesh_arrays.read_polygons(mesh_object.data, to_armature)


def _row(vector: Vector) -> np.ndarray:
    return np.array([vector], np.float64)
