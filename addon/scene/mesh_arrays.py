# SPDX-License-Identifier: GPL-3.0-or-later
"""The points, edges and triangles of a mesh as arrays."""

import hashlib

import _sinew
import numpy as np
from mathutils import Matrix


def read_points(mesh) -> np.ndarray:
    """(vertices, 3) float32: the rest points in mesh space. With shape keys, those of the basis."""
    points = np.empty((len(mesh.vertices), 3), np.float32)
    keys = mesh.shape_keys
    if keys:
        keys.reference_key.points.foreach_get("co", points.reshape(-1))
    else:
        mesh.attributes["position"].data.foreach_get("vector", points.reshape(-1))
    return points


def read_edges(mesh) -> np.ndarray:
    """(edges, 2) int32: the two vertices of each edge."""
    edges = np.empty((len(mesh.edges), 2), np.int32)
    mesh.edges.foreach_get("vertices", edges.reshape(-1))
    return edges


def topology_hash(mesh) -> bytes:
    """A hash of the edges and faces of a mesh. Faces can be deleted, and edges rotated, while all counts stay."""
    sizes, corners = np.empty(len(mesh.polygons), np.int32), np.empty(len(mesh.loops), np.int32)
    mesh.polygons.foreach_get("loop_total", sizes)
    mesh.loops.foreach_get("vertex_index", corners)
    hashed = hashlib.blake2b(digest_size=16)
    for numbers in (read_edges(mesh), sizes, corners):
        hashed.update(numbers.tobytes())
    return hashed.digest()


def read_triangles(mesh) -> np.ndarray:
    """(triangles, 3) int32: the vertices of Blender's triangulation of the faces."""
    mesh.calc_loop_triangles()
    triangles = np.empty((len(mesh.loop_triangles), 3), np.int32)
    mesh.loop_triangles.foreach_get("vertices", triangles.reshape(-1))
    return triangles


def read_corners(mesh) -> tuple[np.ndarray, np.ndarray]:
    """(corners,) int32: the vertex of each corner, face by face. (faces + 1,) int32: where each face's corners start."""
    corners = np.empty(len(mesh.loops), np.int32)
    mesh.loops.foreach_get("vertex_index", corners)
    offsets = np.full(len(mesh.polygons) + 1, len(corners), np.int32)
    mesh.polygons.foreach_get("loop_start", offsets[:-1])
    return corners, offsets


def read_polygons(mesh, to_space: Matrix | None = None) -> _sinew.PolygonMesh:
    """The faces with the rest points, taken from mesh space to another space by `to_space`."""
    column_major = None if to_space is None else np.ascontiguousarray(np.array(to_space, np.float32).T)
    return _sinew.PolygonMesh(read_points(mesh), *read_corners(mesh), column_major)


def read_edges_and_diagonals(mesh, edges: np.ndarray) -> np.ndarray:
    """(pairs, 2) int32: the edges, and both diagonals of each quad, which stiffen it against shear."""
    corners, offsets = read_corners(mesh)
    first = offsets[:-1][np.diff(offsets) == 4]
    diagonals = [np.stack((corners[first + a], corners[first + b]), axis=1) for a, b in ((0, 2), (1, 3))]
    return np.ascontiguousarray(np.concatenate((edges, *diagonals)))


def read_evaluated_points(mesh) -> np.ndarray:
    """(vertices, 3) float32: the points of an evaluated mesh, after its modifiers, in object space."""
    points = np.empty((len(mesh.vertices), 3), np.float32)
    if len(points):
        mesh.attributes["position"].data.foreach_get("vector", points.reshape(-1))
    return points
