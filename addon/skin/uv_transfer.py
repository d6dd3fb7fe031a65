# SPDX-License-Identifier: GPL-3.0-or-later
"""Transfers UV maps from an old surface to the new one that replaces it, so that a texture stays where it was painted.

Each new face belongs to one island of the old map: that of the old face nearest to its middle. A corner whose nearest point
is on the same island takes the UV of that point. Other corners are across a seam: they continue the map of the nearest face
(docs/mathematics/fitting.md, Surface transfer).
"""

import _sinew
import numpy as np

from ..scene import mesh_arrays

SAME_UV = 1e-5
LEAST_DETERMINANT = 1e-9  # of the two edges of a face, of the product of their squared lengths: less has no map


def transfer(old, mesh, transfer_map: _sinew.SurfaceTransfer) -> None:
    """Transfers all UV maps of the old mesh to the new one."""
    if not old.uv_layers:
        return
    surface = _Surface(old)
    points = mesh_arrays.read_points(mesh).astype(np.float64)
    corners, offsets = mesh_arrays.read_corners(mesh)
    faces = np.repeat(transfer_map.nearest_faces, np.diff(offsets))
    face_of_nearest_corner = surface.face_of_corner[transfer_map.nearest_corners][corners]
    is_near = transfer_map.is_near[corners]
    active, rendered = old.uv_layers.active_index, [layer.active_render for layer in old.uv_layers]
    for layer in old.uv_layers:
        uvs = np.empty((len(old.loops), 2), np.float32)
        layer.uv.foreach_get("vector", uvs.reshape(-1))
        islands = surface.islands(uvs)
        values = surface.continued(uvs, faces, points[corners])
        is_same = is_near & (islands[face_of_nearest_corner] == islands[faces])
        values[is_same] = transfer_map.mixed(uvs)[corners][is_same]
        made = mesh.uv_layers.new(name=layer.name, do_init=False)
        made.uv.foreach_set("vector", np.ascontiguousarray(values, np.float32).reshape(-1))
    mesh.uv_layers.active_index = active
    for layer, is_rendered in zip(mesh.uv_layers, rendered, strict=True):
        layer.active_render = is_rendered


class _Surface:
    """The faces of a mesh and which of them share an edge."""

    def __init__(self, mesh):
        self.points = mesh_arrays.read_points(mesh).astype(np.float64)
        self.corners, self.offsets = mesh_arrays.read_corners(mesh)
        sizes = np.diff(self.offsets)
        self.face_of_corner = np.repeat(np.arange(len(sizes)), sizes)
        is_last = np.zeros(len(self.corners), bool)
        is_last[self.offsets[1:] - 1] = True
        self.next_corner = np.where(is_last, self.offsets[self.face_of_corner], np.arange(len(self.corners)) + 1)
        self.sides = self._sides()

    def _sides(self) -> np.ndarray:
        """(pairs, 2) int: corners that start the same edge from both of its sides. Edges of three faces have none."""
        start, end = self.corners.astype(np.int64), self.corners[self.next_corner].astype(np.int64)
        key = np.minimum(start, end) * len(self.points) + np.maximum(start, end)
        order = np.argsort(key, kind="stable")
        _keys, first, counts = np.unique(key[order], return_index=True, return_counts=True)
        first = first[counts == 2]
        return np.stack([order[first], order[first + 1]], axis=1)

    def islands(self, uvs: np.ndarray) -> np.ndarray:
        """(faces,) int: the lowest face of each face's island, whose faces share edges with the same UVs."""
        one, other = self.sides.T
        turned = self.corners[one] == self.corners[self.next_corner[other]]
        start, end = np.where(turned, self.next_corner[other], other), np.where(turned, other, self.next_corner[other])
        gap = np.maximum(np.abs(uvs[one] - uvs[start]), np.abs(uvs[self.next_corner[one]] - uvs[end])).max(axis=1)
        joined = gap < SAME_UV
        a, b = self.face_of_corner[one[joined]], self.face_of_corner[other[joined]]
        labels = np.arange(len(self.offsets) - 1)
        while True:
            before = labels.copy()
            lowest = np.minimum(labels[a], labels[b])
            np.minimum.at(labels, a, lowest)
            np.minimum.at(labels, b, lowest)
            labels = labels[labels]
            if np.array_equal(labels, before):
                return labels

    def continued(self, uvs: np.ndarray, faces: np.ndarray, points: np.ndarray) -> np.ndarray:
        """(points, 2) float64: the UV of each point by the linear map of a face, continued beyond its edges."""
        first = self.offsets[faces]
        second, last = first + 1, self.offsets[faces + 1] - 1
        origin = self.points[self.corners[first]]
        along, across = self.points[self.corners[second]] - origin, self.points[self.corners[last]] - origin
        offset = points - origin
        aa, ab, bb = (along * along).sum(1), (along * across).sum(1), (across * across).sum(1)
        pa, pb = (offset * along).sum(1), (offset * across).sum(1)
        determinant = aa * bb - ab * ab
        is_flat = determinant > LEAST_DETERMINANT * aa * bb
        divisor = np.where(is_flat, determinant, 1.0)
        u = np.where(is_flat, (pa * bb - pb * ab) / divisor, 0.0)[:, None]
        v = np.where(is_flat, (pb * aa - pa * ab) / divisor, 0.0)[:, None]
        base = uvs[first].astype(np.float64)
        return base + u * (uvs[second] - base) + v * (uvs[last] - base)
