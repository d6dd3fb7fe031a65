# SPDX-License-Identifier: GPL-3.0-or-later
"""The skin in its rest shape, in armature space, for rays from inside the body.

A ray that starts inside a limb first meets that limb's own skin, however near the torso is: that is what keeps an arm
an arm. So nothing here asks for the nearest skin where it means the skin around a bone.
"""

from dataclasses import dataclass

import numpy as np
from bpy.types import Mesh, Object
from mathutils import Matrix, Vector
from mathutils.bvhtree import BVHTree

from ....errors import SinewError

MARGIN_OF_SIZE = 0.001
SAME_SKIN_OF_SIZE = 1e-6
MOST_CROSSINGS = 64
INSIDE_TEST_DIRECTIONS = (Vector((0.0, 0.36, 0.93)), Vector((0.0, -0.8, -0.6)), Vector((0.0, 0.86, -0.51)))


@dataclass(frozen=True)
class SkinSurface:
    """A rest mesh that can be asked where its skin is. `outward` is -1 where the mesh's normals look inward."""

    tree: BVHTree
    outward: float
    size_m: float

    @classmethod
    def of(cls, mesh_object: Object, rig: Object) -> "SkinSurface":
        """The rest shape (the basis, without modifiers) of a mesh, seen from its armature."""
        mesh: Mesh = mesh_object.data
        if mesh.is_editmode:
            raise SinewError(f"{mesh_object.name} is in Edit Mode: leave it (Tab) and try again")
        if len(mesh.polygons) == 0:
            raise SinewError(f"'{mesh_object.name}' has no faces, so there is no skin to fit muscles under")
        if abs(rig.matrix_world.determinant()) < 1e-12:
            raise SinewError(f"'{rig.name}' is scaled to nothing: give it a scale (Object Properties, Transform)")
        points = _in_space(_rest_points(mesh), rig.matrix_world.inverted() @ mesh_object.matrix_world)
        if not np.isfinite(points).all():
            raise SinewError(f"'{mesh_object.name}' has vertices that are not finite numbers: repair the mesh first")
        points, triangles = _fans(mesh, points)
        return cls(
            tree=BVHTree.FromPolygons(points.tolist(), triangles.tolist(), all_triangles=True),
            outward=1.0 if _signed_volume(points, triangles) >= 0 else -1.0,
            size_m=float(np.ptp(points, axis=0).max()),
        )

    @property
    def margin_m(self) -> float:
        """How far under the skin a belly ends: 1-2 mm on a person."""
        return MARGIN_OF_SIZE * self.size_m

    def distance_along(self, origin: Vector, direction: Vector) -> float | None:
        """How far the skin is from a point inside; 0 where the point is outside already, None where no skin is."""
        _, normal, _, distance = self.tree.ray_cast(origin, direction)
        if distance is None or self._leaves(normal, direction):
            return distance
        return self._distance_through_shells(origin, direction)

    def _leaves(self, normal: Vector, direction: Vector) -> bool:
        return normal.dot(direction) * self.outward > 0

    def _distance_through_shells(self, origin: Vector, direction: Vector) -> float:
        """Where the first skin that a ray meets is one that it enters: it starts outside, or another shell begins."""
        crossings = []
        step_m, passed_m = SAME_SKIN_OF_SIZE * self.size_m, 0.0
        while len(crossings) < MOST_CROSSINGS:
            _, normal, _, distance = self.tree.ray_cast(origin + direction * passed_m, direction)
            if distance is None:
                break
            crossings.append((passed_m + distance, -1 if self._leaves(normal, direction) else 1))
            passed_m += distance + step_m
        shells = -sum(change for _, change in crossings)
        if shells <= 0:
            return 0.0
        for distance, change in crossings:
            shells += change
            if shells == 0:
                return distance
        return 0.0

    def is_inside(self, point: Vector) -> bool:
        """Whether the skin encloses a point: most of three rays leave through it."""
        leaving = [self.distance_along(point, direction) for direction in INSIDE_TEST_DIRECTIONS]
        return sum(bool(distance) for distance in leaving) >= 2

    def toward_skin(self, point: Vector) -> Vector | None:
        """From a point inside to the nearest skin; None outside."""
        return self.tree.find_nearest(point)[0] - point if self.is_inside(point) else None

    def nearest(self, point: Vector) -> Vector:
        """The nearest point of the skin, from either side of it."""
        return self.tree.find_nearest(point)[0]

    def nearest_distance(self, point: Vector) -> float:
        """Metres to the nearest skin, on either side of it."""
        return self.tree.find_nearest(point)[3]


def _rest_points(mesh: Mesh) -> np.ndarray:
    points = np.empty(3 * len(mesh.vertices), dtype=np.float32)
    if mesh.shape_keys is not None:
        mesh.shape_keys.reference_key.points.foreach_get("co", points)
    else:
        mesh.attributes["position"].data.foreach_get("vector", points)
    return points.reshape(-1, 3)


def _in_space(points: np.ndarray, matrix: Matrix) -> np.ndarray:
    affine = np.array(matrix, dtype=np.float64)
    return points @ affine[:3, :3].T + affine[:3, 3]


def _fans(mesh: Mesh, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Each face as a fan around its middle: unlike a quad's diagonal, that is the same on the left and on the right."""
    starts = np.empty(len(mesh.polygons), dtype=np.int32)
    sizes = np.empty(len(mesh.polygons), dtype=np.int32)
    corners = np.empty(len(mesh.loops), dtype=np.int32)
    mesh.polygons.foreach_get("loop_start", starts)
    mesh.polygons.foreach_get("loop_total", sizes)
    mesh.loops.foreach_get("vertex_index", corners)
    middles = np.add.reduceat(points[corners], starts, axis=0) / sizes[:, None]
    following = np.roll(corners, -1)
    following[starts + sizes - 1] = corners[starts]
    tips = len(points) + np.repeat(np.arange(len(sizes)), sizes)
    return np.concatenate((points, middles)), np.stack((corners, following, tips), axis=1)


def _signed_volume(points: np.ndarray, triangles: np.ndarray) -> float:
    a, b, c = (points[triangles[:, corner]] - points.mean(axis=0) for corner in range(3))
    return float(np.einsum("ij,ij->", a, np.cross(b, c)))
