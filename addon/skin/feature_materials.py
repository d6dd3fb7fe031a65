# SPDX-License-Identifier: GPL-3.0-or-later
"""Materials of a grown skin: dark eyes, nose and pads, and claws on the faces over these features.

A user paints over them or replaces them. When a skin is grown again, the faces keep the materials of the old surface.
"""

from collections.abc import Sequence

import bpy
import numpy as np

from ..muscles.placing.place import features
from ..scene import mesh_arrays
from ..scene.tissue_empty import TissueShape

# name, color and roughness of each material, and the kinds of feature that it covers
SKIN = ("Skin", (0.52, 0.37, 0.25, 1.0), 0.6, (features.TOE, features.MUZZLE, features.CHIN))
COVERS = (
    ("Eyes", (0.03, 0.05, 0.02, 1.0), 0.12, (features.EYE,)),
    ("Nose and Pads", (0.11, 0.05, 0.05, 1.0), 0.5, (features.NOSE, features.PAD)),
    ("Claws", (0.75, 0.70, 0.60, 1.0), 0.35, (features.CLAW,)),
)
REACH_VOXELS = 0.35  # a face is over a feature if it is at most this far outside of the feature and its skin
MOVED_VOXELS = 0.4  # how far a vertex is moved to an outline: less than half an edge, so that no face turns over
LEAST_STEEPNESS = 0.05  # of a feature's distance along the surface; less than this defines no outline


def assign(mesh, shapes: Sequence[TissueShape], thickness_m: np.ndarray, voxel_m: float) -> None:
    """Gives a new mesh the materials, and each face the one of the feature that it is over.

    The edges between two materials are moved onto the outline of the feature, so that they run around an eye as a loop.
    shapes: tissues in the space of the mesh. thickness_m: (shapes,) of the skin over each.
    """
    if not any(features.is_feature(shape.name, *cover[-1]) for shape in shapes for cover in COVERS):
        return
    reach_m = REACH_VOXELS * voxel_m
    centres = _face_centres(mesh)
    slots, owners = np.zeros(len(centres), np.int32), np.full(len(centres), -1, np.int32)
    nearest_m = np.full(len(centres), reach_m)
    for slot, (name, color, roughness, kinds) in enumerate((SKIN, *COVERS)):
        mesh.materials.append(_material(name, color, roughness))
        for index, shape in enumerate(shapes):
            if features.is_feature(shape.name, *kinds):
                distance_m = _distance(shape, centres) - thickness_m[index]
                is_nearer = distance_m < nearest_m
                slots[is_nearer], owners[is_nearer], nearest_m[is_nearer] = slot, index, distance_m[is_nearer]
    mesh.polygons.foreach_set("material_index", slots)
    owners[slots == 0] = -1
    _move_outlines(mesh, shapes, owners, thickness_m + reach_m, MOVED_VOXELS * voxel_m)


def _move_outlines(mesh, shapes: Sequence[TissueShape], owners: np.ndarray, reach_m: np.ndarray, most_m: float) -> None:
    """Moves the vertices between a feature's faces and others along the surface, to where the feature's faces end.

    owners: (faces,) int32, the shape that each face is over, -1 for none. reach_m: (shapes,) the distance at which its faces
    end. most_m: the farthest that a vertex is moved.
    """
    points = mesh_arrays.read_points(mesh).astype(np.float64)
    normals = np.empty(len(points) * 3, np.float32)
    mesh.vertices.foreach_get("normal", normals)
    normals = normals.reshape(-1, 3)
    corners, offsets = mesh_arrays.read_corners(mesh)
    of_corners = np.repeat(owners, np.diff(offsets))
    for owner in np.unique(owners[owners >= 0]).tolist():
        inside = np.zeros(len(points), bool)
        outside = np.zeros(len(points), bool)
        inside[corners[of_corners == owner]] = True
        outside[corners[of_corners == -1]] = True
        border = np.flatnonzero(inside & outside)
        distance_m = _distance(shapes[owner], points[border])
        step_m = 1e-4 * most_m
        ahead = [_distance(shapes[owner], points[border] + axis) for axis in np.eye(3) * step_m]
        slope = (np.stack(ahead, axis=1) - distance_m[:, None]) / step_m
        missing_m = distance_m - reach_m[owner]
        along = slope - normals[border] * (slope * normals[border]).sum(axis=1, keepdims=True)
        steepness = np.maximum((along**2).sum(axis=1), LEAST_STEEPNESS)
        step = -along * (missing_m / steepness)[:, None]
        length_m = np.linalg.norm(step, axis=1, keepdims=True)
        points[border] += step * np.minimum(1.0, most_m / np.maximum(length_m, 1e-12))
    mesh.attributes["position"].data.foreach_set("vector", points.astype(np.float32).reshape(-1))
    mesh.update()


def _face_centres(mesh) -> np.ndarray:
    """(faces, 3) float64."""
    points = mesh_arrays.read_points(mesh).astype(np.float64)
    corners, offsets = mesh_arrays.read_corners(mesh)
    sums = np.add.reduceat(points[corners], offsets[:-1], axis=0)
    return sums / np.diff(offsets)[:, None]


def _distance(shape: TissueShape, points: np.ndarray) -> np.ndarray:
    """(points,) float64: the distance from an ellipsoid to first order (Taubin 1994), m; negative inside."""
    semi_axes = np.array(shape.semi_axes)
    local = (points - np.array(shape.centre)) @ np.array(shape.rotation.to_matrix())
    scaled = np.linalg.norm(local / semi_axes, axis=1)
    slope = np.linalg.norm(local / semi_axes**2, axis=1)
    return scaled * (scaled - 1.0) / np.maximum(slope, 1e-12)


def _material(name: str, color: tuple[float, ...], roughness: float):
    material = bpy.data.materials.get(name) or bpy.data.materials.new(name)
    if material.users == 0:
        material.diffuse_color, material.roughness = color, roughness
        if material.node_tree is None:
            material.use_nodes = True
        shader = next((node for node in material.node_tree.nodes if node.type == "BSDF_PRINCIPLED"), None)
        if shader:
            shader.inputs["Base Color"].default_value = color
            shader.inputs["Roughness"].default_value = roughness
    return material
