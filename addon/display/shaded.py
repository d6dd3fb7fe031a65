# SPDX-License-Identifier: GPL-3.0-or-later
"""Shaded muscles: one mesh object per rig that shows all ellipsoids and tendons in the current pose.

The mesh has one point per ellipsoid and per piece of a tendon. Each frame writes the points and their attributes with
`foreach_set`; in saved files the mesh is empty. One matrix attribute would be simpler, but writing it in bulk corrupts
memory in Blender 4.5.
"""

import bpy
import numpy as np

from ..scene import stored_settings
from . import ellipsoid_nodes

_MODIFIER = "Sinew Ellipsoids"
_VECTORS = ("position", ellipsoid_nodes.AXIS_X, ellipsoid_nodes.AXIS_Z, ellipsoid_nodes.SCALE)


def find(rig):
    """The object of a rig's shaded muscles, or None. A duplicated rig has none of its own."""
    settings = stored_settings.rig_of(rig)
    shaded = settings.shaded if settings is not None else None
    return shaded if shaded is not None and shaded.parent == rig else None


def create(rig, collection):
    """Creates the object of a rig's shaded muscles in `collection`. It shows nothing until the next frame."""
    name = f"{rig.name} Shaded Muscles"
    shaded = bpy.data.objects.new(name, bpy.data.meshes.new(name))
    collection.objects.link(shaded)
    shaded.parent = rig
    shaded.hide_select = shaded.hide_render = True
    shaded.modifiers.new(_MODIFIER, "NODES").node_group = ellipsoid_nodes.group()
    rig.sinew.rig.shaded = shaded
    return shaded


def remove(rig):
    """Removes a rig's shaded muscles, with their mesh, node group and materials."""
    shaded = find(rig)
    if shaded:
        mesh = shaded.data
        bpy.data.objects.remove(shaded)
        bpy.data.meshes.remove(mesh)
        ellipsoid_nodes.remove_unused()
    settings = stored_settings.rig_of(rig)
    if settings is not None:
        settings.shaded = None


def renew(rig):
    """Gives the shaded muscles of a file from an older Sinew the shapes of this one."""
    shaded = find(rig)
    modifier = shaded.modifiers.get(_MODIFIER) if shaded else None
    if modifier and not shaded.library:
        group = ellipsoid_nodes.group()
        if modifier.node_group != group:
            modifier.node_group = group
            ellipsoid_nodes.remove_unused()


def show(shaded, matrices: np.ndarray, shapes: np.ndarray):
    """Makes the object show these ellipsoids and tendons.

    matrices: (points, 4, 4) float32, column-major, from the unit shape to each shape in armature space. shapes: (points,)
    int32, what each point shows, as the attribute SHAPE of `ellipsoid_nodes`.
    """
    mesh = shaded.data
    columns = matrices[:, :3, :3]
    lengths = np.linalg.norm(columns, axis=2)
    values = (matrices[:, 3, :3], columns[:, 0], columns[:, 2], lengths)
    if len(mesh.vertices) != len(matrices) or ellipsoid_nodes.SHAPE not in mesh.attributes:
        _resize(mesh, len(matrices))
    changed = False
    for name, value in zip(_VECTORS, values):
        changed |= _write(mesh.attributes[name], "vector", np.ascontiguousarray(value, np.float32).reshape(-1))
    changed |= _write(mesh.attributes[ellipsoid_nodes.SHAPE], "value", np.ascontiguousarray(shapes, np.int32))
    if changed:
        mesh.update_tag()


def clear(rig):
    """Empties the mesh before the file is saved."""
    shaded = find(rig)
    if shaded and len(shaded.data.vertices):
        shaded.data.clear_geometry()


def _resize(mesh, count: int):
    mesh.clear_geometry()
    mesh.vertices.add(count)
    for name in _VECTORS[1:]:
        mesh.attributes.new(name, "FLOAT_VECTOR", "POINT")
    mesh.attributes.new(ellipsoid_nodes.SHAPE, "INT", "POINT")


def _write(attribute, name: str, values: np.ndarray) -> bool:
    """Writes values that differ from those of the attribute. Returns whether they do."""
    current = np.empty_like(values)
    attribute.data.foreach_get(name, current)
    if np.array_equal(current, values):
        return False
    attribute.data.foreach_set(name, values)
    return True
