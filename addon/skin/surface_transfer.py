# SPDX-License-Identifier: GPL-3.0-or-later
"""Transfers what the user made on a mesh to a new surface in its place: materials, painted attributes, vertex groups.

Each point of the new surface takes the values of the nearest point of the old one, within a distance. Beyond that distance
it takes nothing.
"""

import _sinew
import numpy as np

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
# every mesh has these, or the new surface gets its own
_DERIVED = {"position", "material_index", "sharp_face", correction_modifier.CORRECTION_ATTRIBUTE}


def transfer(skin, mesh, derived_groups: set[str], near: float):
    """Makes `mesh` the surface of `skin`, with the data of the old surface.

    derived_groups: names of vertex groups that are not transferred.
    near: the largest distance of a transfer, in the skin's space.
    """
    former = skin.data
    groups = {group.name: group.index for group in skin.vertex_groups if group.name not in derived_groups}
    for material in former.materials:
        mesh.materials.append(material)
    if not former.polygons or not np.isfinite(mesh_arrays.read_points(former)).all():
        skin.data = mesh
        return
    nearest = _sinew.SurfaceTransfer(mesh_arrays.read_polygons(former), mesh_arrays.read_polygons(mesh), near)
    corners, _offsets = mesh_arrays.read_corners(former)
    painted = {name: nearest.mixed(_weights(former, index)[corners, None])[:, 0] for name, index in groups.items()}
    _transfer_materials(former, mesh, nearest.nearest_faces)
    for attribute in former.attributes:
        if attribute.name not in _DERIVED and not attribute.name.startswith(".") and not _is_uv(former, attribute):
            _transfer_attribute(former, mesh, attribute, nearest)
    skin.data = mesh  # which has no vertex groups: Blender keeps them, with their names, in the mesh
    for name, weights in painted.items():
        group = skin.vertex_groups.new(name=name)
        for vertex in np.flatnonzero(weights > 0.0).tolist():
            group.add((vertex,), float(weights[vertex]), "REPLACE")


def _is_uv(mesh, attribute) -> bool:
    """UVs are not transferred: across a seam there is no value between two corners."""
    return attribute.name in mesh.uv_layers


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


def _transfer_attribute(former, mesh, attribute, nearest: _sinew.SurfaceTransfer):
    kind, domain = attribute.data_type, attribute.domain
    if kind not in _WIDTHS or domain not in ("POINT", "CORNER", "FACE"):
        return
    width, field, number = _WIDTHS[kind]
    values = np.empty(len(attribute.data) * width, number)
    attribute.data.foreach_get(field, values)
    values = values.reshape(-1, width)
    if domain == "FACE":
        found = values[nearest.nearest_faces]
    else:
        of_corners = values[mesh_arrays.read_corners(former)[0]] if domain == "POINT" else values
        found = _of_vertices(of_corners, nearest, kind)
        if domain == "CORNER":
            found = found[mesh_arrays.read_corners(mesh)[0]]
    # the new mesh's own name, should Blender have changed it
    made = mesh.attributes.get(attribute.name) or mesh.attributes.new(attribute.name, kind, domain)
    made.data.foreach_set(field, np.ascontiguousarray(found).reshape(-1))
    if former.color_attributes.active_color_name == attribute.name:
        mesh.color_attributes.active_color = made
    if former.color_attributes.render_color_index >= 0 and attribute.name in mesh.color_attributes:
        mesh.color_attributes.render_color_index = mesh.color_attributes.find(
            former.color_attributes[former.color_attributes.render_color_index].name
        )


def _of_vertices(of_corners: np.ndarray, nearest: _sinew.SurfaceTransfer, kind: str) -> np.ndarray:
    """The value of each new vertex: mixed from the corners of the nearest face, or that of the nearest corner."""
    if kind in _MIXED:
        return nearest.mixed(np.nan_to_num(of_corners))
    found = of_corners[nearest.nearest_corners]
    found[~nearest.is_near] = 0
    return found
