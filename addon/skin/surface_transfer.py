# SPDX-License-Identifier: GPL-3.0-or-later
"""What a person made on a mesh goes over to a new surface in its place: materials, painted attributes, vertex groups.

Each point of the new surface takes what the nearest point of the old one has, within a distance; beyond it, nothing.
"""

from dataclasses import dataclass

import numpy as np
from mathutils import Vector
from mathutils.bvhtree import BVHTree
from mathutils.interpolate import poly_3d_calc

from ..scene import correction_modifier, mesh_arrays

_WIDTHS = {
    "FLOAT": (1, "value", np.float32),
    "INT": (1, "value", np.int32),
    "INT8": (1, "value", np.int32),
    "BOOLEAN": (1, "value", bool),
    "FLOAT2": (2, "vector", np.float32),
    "FLOAT_VECTOR": (3, "vector", np.float32),
    "FLOAT_COLOR": (4, "color", np.float32),
    "BYTE_COLOR": (4, "color", np.float32),
    "QUATERNION": (4, "value", np.float32),
}
_MIXED = {"FLOAT", "FLOAT2", "FLOAT_VECTOR", "FLOAT_COLOR", "BYTE_COLOR"}
# what every mesh has, and what is made anew with the surface
_DERIVED = {"position", "material_index", "sharp_face", correction_modifier.CORRECTION_ATTRIBUTE}


@dataclass(frozen=True)
class _Nearest:
    """For each vertex of the new surface, in the order of its vertices: the face of the old one that is nearest.

    corners: (vertices, most corners) places of the face's corners among all corners; shares: how much of each.
    """

    faces: np.ndarray
    corners: np.ndarray
    shares: np.ndarray
    is_near: np.ndarray


def transfer(skin, mesh, derived_groups: set[str], near: float):
    """Makes `mesh` the surface of `skin`, with what the old one had.

    derived_groups: names of vertex groups that are made anew. near: how far what goes over may lie, in the skin's space.
    """
    former = skin.data
    groups = {group.name: group.index for group in skin.vertex_groups if group.name not in derived_groups}
    for material in former.materials:
        mesh.materials.append(material)
    if not former.polygons:
        skin.data = mesh
        return
    points = mesh_arrays.read_points(former)
    faces = [tuple(face.vertices) for face in former.polygons]
    tree = BVHTree.FromPolygons(points.tolist(), faces)
    new_points = mesh_arrays.read_points(mesh)
    nearest = _nearest(tree, points, former, new_points, near)
    painted = {name: _weights(former, index)[_vertices(former)[nearest.corners]] for name, index in groups.items()}
    nearest_face = np.array([tree.find_nearest(face.center)[2] for face in mesh.polygons], np.intp)
    _transfer_materials(former, mesh, nearest_face)
    for attribute in former.attributes:
        if attribute.name not in _DERIVED and not attribute.name.startswith(".") and not _is_uv(former, attribute):
            _transfer_attribute(former, mesh, attribute, nearest, nearest_face)
    skin.data = mesh  # which has no vertex groups: Blender keeps them, with their names, in the mesh
    for name, weights in painted.items():
        group, mixed = skin.vertex_groups.new(name=name), (weights * nearest.shares).sum(axis=1)
        for vertex in np.flatnonzero(nearest.is_near & (mixed > 0.0)).tolist():
            group.add((vertex,), float(mixed[vertex]), "REPLACE")


def _is_uv(mesh, attribute) -> bool:
    """UVs are unwrapped anew: across the seams of the old ones nothing lies between two corners."""
    return attribute.name in mesh.uv_layers


def _vertices(mesh) -> np.ndarray:
    """The vertex of each corner of all faces."""
    vertices = np.empty(len(mesh.loops), np.int32)
    mesh.loops.foreach_get("vertex_index", vertices)
    return vertices


def _nearest(tree, points: np.ndarray, former, new_points: np.ndarray, near: float) -> _Nearest:
    starts = [face.loop_start for face in former.polygons]
    most = max(face.loop_total for face in former.polygons)
    corner_points = [Vector(point) for point in points.tolist()]
    faces = np.empty(len(new_points), np.intp)
    corners = np.zeros((len(new_points), most), np.intp)
    shares = np.zeros((len(new_points), most), np.float32)
    is_near = np.empty(len(new_points), bool)
    for vertex, point in enumerate(new_points.tolist()):
        place, _normal, face, distance = tree.find_nearest(point)
        own = former.polygons[face].vertices
        faces[vertex], is_near[vertex] = face, distance <= near
        corners[vertex, : len(own)] = range(starts[face], starts[face] + len(own))
        shares[vertex, : len(own)] = poly_3d_calc([corner_points[corner] for corner in own], place)
    return _Nearest(faces, corners, shares, is_near)


def _weights(mesh, group: int) -> np.ndarray:
    """(vertices,) float32: a vertex group's weights, 0 where it has none."""
    weights = np.zeros(len(mesh.vertices), np.float32)
    for vertex in mesh.vertices:
        for element in vertex.groups:
            if element.group == group:
                weights[vertex.index] = element.weight
    return weights


def _transfer_materials(former, mesh, nearest_face: np.ndarray):
    indices = np.empty(len(former.polygons), np.int32)
    former.polygons.foreach_get("material_index", indices)
    mesh.polygons.foreach_set("material_index", np.ascontiguousarray(indices[nearest_face]))


def _transfer_attribute(former, mesh, attribute, nearest: _Nearest, nearest_face: np.ndarray):
    kind, domain = attribute.data_type, attribute.domain
    if kind not in _WIDTHS or domain not in ("POINT", "CORNER", "FACE"):
        return
    width, field, number = _WIDTHS[kind]
    values = np.empty(len(attribute.data) * width, number)
    attribute.data.foreach_get(field, values)
    values = values.reshape(-1, width)
    if domain == "FACE":
        found = values[nearest_face]
    else:
        found = _of_vertices(values[_vertices(former)] if domain == "POINT" else values, nearest, kind)
        if domain == "CORNER":
            found = found[_vertices(mesh)]
    # the new mesh's own name, should Blender have changed it
    made = mesh.attributes.get(attribute.name) or mesh.attributes.new(attribute.name, kind, domain)
    made.data.foreach_set(field, np.ascontiguousarray(found).reshape(-1))
    if former.color_attributes.active_color_name == attribute.name:
        mesh.color_attributes.active_color = made
    if former.color_attributes.render_color_index >= 0 and attribute.name in mesh.color_attributes:
        mesh.color_attributes.render_color_index = mesh.color_attributes.find(
            former.color_attributes[former.color_attributes.render_color_index].name
        )


def _of_vertices(of_corners: np.ndarray, nearest: _Nearest, kind: str) -> np.ndarray:
    """What each new vertex gets, of the values of all corners: mixed, or where that can't be the nearest corner's."""
    at_corners = of_corners[nearest.corners]
    if kind in _MIXED:
        found = (at_corners * nearest.shares[..., None]).sum(axis=1, dtype=np.float32)
    else:
        found = at_corners[np.arange(len(at_corners)), nearest.shares.argmax(axis=1)]
    found[~nearest.is_near] = 0
    return found
