# SPDX-License-Identifier: GPL-3.0-or-later
"""Transfers materials, painted attributes, UV maps and vertex groups from an old surface to the new one that replaces it.

Each point of the new surface takes the values of the nearest point of the old one, within a distance
(docs/mathematics/fitting.md, Surface transfer).
"""

import _sinew
import numpy as np

from ..scene import correction_modifier, mesh_arrays
from . import uv_transfer

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
# the new surface has values for these
_DERIVED = {"position", "material_index", "sharp_face", correction_modifier.CORRECTION_ATTRIBUTE}


def transfer(skin, mesh, derived_groups: set[str], max_distance: float):
    """Makes `mesh` the surface of `skin` and transfers the data of the old surface to it.

    derived_groups: names of vertex groups that are not transferred.
    max_distance: the largest distance of a transfer, in the space of the skin.
    """
    old = skin.data
    groups = {group.name: group.index for group in skin.vertex_groups if group.name not in derived_groups}
    for material in old.materials:
        mesh.materials.append(material)
    if not old.polygons or not np.isfinite(mesh_arrays.read_points(old)).all():
        skin.data = mesh
        return
    transfer_map = _sinew.SurfaceTransfer(mesh_arrays.read_polygons(old), mesh_arrays.read_polygons(mesh), max_distance)
    corners, _offsets = mesh_arrays.read_corners(old)
    painted = {name: transfer_map.mixed(_weights(old, index)[corners, None])[:, 0] for name, index in groups.items()}
    _transfer_materials(old, mesh, transfer_map.nearest_faces)
    uv_transfer.transfer(old, mesh, transfer_map)
    for attribute in old.attributes:
        if attribute.name not in _DERIVED and not attribute.name.startswith(".") and not _is_uv(old, attribute):
            _transfer_attribute(old, mesh, attribute, transfer_map)
    skin.data = mesh  # Blender stores vertex groups with their names in the mesh, so there are none now
    for name, weights in painted.items():
        group = skin.vertex_groups.new(name=name)
        for vertex in np.flatnonzero(weights > 0.0).tolist():
            group.add((vertex,), float(weights[vertex]), "REPLACE")


def _is_uv(mesh, attribute) -> bool:
    """UVs are transferred by `uv_transfer`, because two corners across a seam have no value between them."""
    return attribute.name in mesh.uv_layers


def _weights(mesh, group: int) -> np.ndarray:
    """(vertices,) float32: the weights of a vertex group; 0 for a vertex outside it."""
    weights = np.zeros(len(mesh.vertices), np.float32)
    for vertex in mesh.vertices:
        for element in vertex.groups:
            if element.group == group:
                weights[vertex.index] = element.weight
    return weights


def _transfer_materials(old, mesh, nearest_face: np.ndarray):
    indices = np.empty(len(old.polygons), np.int32)
    old.polygons.foreach_get("material_index", indices)
    mesh.polygons.foreach_set("material_index", np.ascontiguousarray(indices[nearest_face]))


def _transfer_attribute(old, mesh, attribute, transfer_map: _sinew.SurfaceTransfer):
    kind, domain = attribute.data_type, attribute.domain
    if kind not in _WIDTHS or domain not in ("POINT", "CORNER", "FACE"):
        return
    width, field, number = _WIDTHS[kind]
    values = np.empty(len(attribute.data) * width, number)
    attribute.data.foreach_get(field, values)
    values = values.reshape(-1, width)
    if domain == "FACE":
        transferred = values[transfer_map.nearest_faces]
    else:
        of_corners = values[mesh_arrays.read_corners(old)[0]] if domain == "POINT" else values
        transferred = _of_vertices(of_corners, transfer_map, kind)
        if domain == "CORNER":
            transferred = transferred[mesh_arrays.read_corners(mesh)[0]]
    # Blender may have changed the name of a new attribute
    target = mesh.attributes.get(attribute.name) or mesh.attributes.new(attribute.name, kind, domain)
    target.data.foreach_set(field, np.ascontiguousarray(transferred).reshape(-1))
    if old.color_attributes.active_color_name == attribute.name:
        mesh.color_attributes.active_color = target
    if old.color_attributes.render_color_index >= 0 and attribute.name in mesh.color_attributes:
        mesh.color_attributes.render_color_index = mesh.color_attributes.find(
            old.color_attributes[old.color_attributes.render_color_index].name
        )


def _of_vertices(of_corners: np.ndarray, transfer_map: _sinew.SurfaceTransfer, kind: str) -> np.ndarray:
    """The values of the new vertices: mixed from the corners of the nearest face, or those of the nearest corner."""
    if kind in _MIXED:
        return transfer_map.mixed(np.nan_to_num(of_corners))
    transferred = of_corners[transfer_map.nearest_corners]
    transferred[~transfer_map.is_near] = 0
    return transferred
