# SPDX-License-Identifier: GPL-3.0-or-later
"""Shaded muscles: one mesh object a rig that shows all posed ellipsoids, coloured by their stretch.

Its mesh is one point an ellipsoid, written in every frame with `foreach_set` and empty in saved files: all of it follows
from tissues and pose. A matrix attribute would be simpler, but writing one in bulk corrupts memory in Blender 4.5.
"""

import bpy
import numpy as np

from . import ellipsoid_nodes, stretch_colours

_MODIFIER = "Sinew Ellipsoids"
_VECTORS = ("position", ellipsoid_nodes.AXIS_X, ellipsoid_nodes.AXIS_Z, ellipsoid_nodes.SCALE)


def find(rig):
    """The rig's shaded muscles, or None; a duplicate of the rig has none until it gets its own."""
    found = rig.sinew.shaded
    return found if found is not None and found.parent == rig else None


def is_shaded(candidate) -> bool:
    """Whether an object shows shaded muscles."""
    parent = candidate.parent
    return parent is not None and parent.is_property_set("sinew") and parent.sinew.shaded == candidate


def create(rig, collection):
    """The rig's shaded muscles, in `collection`; they show nothing until the next frame."""
    name = f"{rig.name} Shaded Muscles"
    found = bpy.data.objects.new(name, bpy.data.meshes.new(name))
    collection.objects.link(found)
    found.parent = rig
    found.hide_select = found.hide_render = True
    found.modifiers.new(_MODIFIER, "NODES").node_group = ellipsoid_nodes.group()
    rig.sinew.shaded = found
    return found


def remove(rig):
    """Takes the shaded muscles away, with all that was made for them."""
    found = find(rig)
    if found:
        mesh = found.data
        bpy.data.objects.remove(found)
        bpy.data.meshes.remove(mesh)
        ellipsoid_nodes.remove_unused()
    rig.sinew.shaded = None


def show(found, matrices: np.ndarray, stretch: np.ndarray):
    """Shows ellipsoids.

    matrices: (ellipsoids, 4, 4) float32, column-major: the unit sphere to each. stretch: (ellipsoids,), 1 at rest.
    """
    mesh = found.data
    columns = matrices[:, :3, :3]
    lengths = np.linalg.norm(columns, axis=2)
    values = (matrices[:, 3, :3], columns[:, 0], columns[:, 2], lengths)
    steps = stretch_colours.steps_of(stretch)
    if len(mesh.vertices) != len(matrices) or ellipsoid_nodes.STEP not in mesh.attributes:
        _resize(mesh, len(matrices))
    changed = False
    for name, value in zip(_VECTORS, values):
        changed |= _write(mesh.attributes[name], "vector", np.ascontiguousarray(value, np.float32).reshape(-1))
    changed |= _write(mesh.attributes[ellipsoid_nodes.STEP], "value", steps)
    if changed:
        mesh.update_tag()


def clear(rig):
    """Empties the mesh, so that a file holds nothing derived."""
    found = find(rig)
    if found and len(found.data.vertices):
        found.data.clear_geometry()


def _resize(mesh, count: int):
    mesh.clear_geometry()
    mesh.vertices.add(count)
    for name in _VECTORS[1:]:
        mesh.attributes.new(name, "FLOAT_VECTOR", "POINT")
    mesh.attributes.new(ellipsoid_nodes.STEP, "INT", "POINT")


def _write(attribute, name: str, values: np.ndarray) -> bool:
    present = np.empty_like(values)
    attribute.data.foreach_get(name, present)
    if np.array_equal(present, values):
        return False
    attribute.data.foreach_set(name, values)
    return True
