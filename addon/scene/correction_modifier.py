# SPDX-License-Identifier: GPL-3.0-or-later
"""The only reader and writer of skin meshes: rest points, edges and weights in, the correction out. (What a person paints
for Sinew on them is for `painted_io`.)

The correction is a vector attribute that a Geometry Nodes modifier, first in the stack, adds to the points before the
Armature modifier. Nothing else of the mesh is touched.
"""

import bpy
import numpy as np

from ..errors import SinewError

CORRECTION_ATTRIBUTE = "sinew_correction"
MODIFIER = "Sinew"
NODE_GROUP = "Sinew Correction"
_GROUP_MARK = "sinew_correction_group"


def add_correction(skin):
    """Gives a mesh the correction attribute, zero everywhere, and the modifier that adds it, first in the stack."""
    _attribute(skin.data)
    if modifier_of(skin) is None:
        modifier = skin.modifiers.new(MODIFIER, "NODES")
        modifier.node_group = _node_group()
        modifier.show_in_editmode = False
        modifier.show_expanded = False
        skin.modifiers.move(skin.modifiers.find(modifier.name), 0)


def remove_correction(skin):
    """Takes the modifier, the attribute (where no other object uses it) and the node group (likewise) away."""
    modifier = modifier_of(skin)
    if modifier:
        group = modifier.node_group
        skin.modifiers.remove(modifier)
        if group.users == 0:
            bpy.data.node_groups.remove(group)
    shared = any(
        other.data == skin.data and other != skin and modifier_of(other)
        for other in bpy.data.objects
        if other.type == "MESH"
    )
    attribute = skin.data.attributes.get(CORRECTION_ATTRIBUTE)
    if attribute and not shared:
        skin.data.attributes.remove(attribute)


def modifier_of(skin):
    """Sinew's modifier on a mesh, known by its node group (so it may be renamed), or None."""
    return next(
        (
            modifier
            for modifier in skin.modifiers
            if modifier.type == "NODES" and modifier.node_group and modifier.node_group.get(_GROUP_MARK)
        ),
        None,
    )


def read_correction(mesh, out: np.ndarray) -> bool:
    """Fills `out`, (vertices, 3) float32, with the correction that the mesh holds; False where it holds none."""
    attribute = mesh.attributes.get(CORRECTION_ATTRIBUTE)
    if attribute is None or len(attribute.data) != len(out):
        return False
    attribute.data.foreach_get("vector", out.reshape(-1))
    return True


def write_correction(mesh, correction: np.ndarray):
    """Writes the correction, (vertices, 3) float32, mesh space; Blender then evaluates the mesh anew.

    A linked mesh (of a library override) holds it in memory alone, as it should.
    """
    data = _attribute(mesh).data
    if mesh.library is None:
        data.foreach_set("vector", correction.reshape(-1))
        return
    # Blender passes over foreach_set on linked data without a word, and takes single values
    present = np.empty_like(correction)
    data.foreach_get("vector", present.reshape(-1))
    for vertex in np.flatnonzero((present != correction).any(axis=1)).tolist():
        data[vertex].vector = correction[vertex]


def _attribute(mesh):
    attribute = mesh.attributes.get(CORRECTION_ATTRIBUTE)
    if attribute and (attribute.domain != "POINT" or attribute.data_type != "FLOAT_VECTOR"):
        raise SinewError(f"{mesh.name}: attribute '{CORRECTION_ATTRIBUTE}' is not a vector per vertex; remove or rename it")
    return attribute or mesh.attributes.new(CORRECTION_ATTRIBUTE, "FLOAT_VECTOR", "POINT")


def _node_group():
    for group in bpy.data.node_groups:
        if group.get(_GROUP_MARK) and group.library is None:
            return group
    group = bpy.data.node_groups.new(NODE_GROUP, "GeometryNodeTree")
    group[_GROUP_MARK] = True
    group.is_modifier = True
    group.interface.new_socket("Geometry", in_out="INPUT", socket_type="NodeSocketGeometry")
    group.interface.new_socket("Geometry", in_out="OUTPUT", socket_type="NodeSocketGeometry")
    nodes, links = group.nodes, group.links
    entry = nodes.new("NodeGroupInput")
    correction = nodes.new("GeometryNodeInputNamedAttribute")
    correction.data_type = "FLOAT_VECTOR"
    correction.inputs["Name"].default_value = CORRECTION_ATTRIBUTE
    move = nodes.new("GeometryNodeSetPosition")
    leave = nodes.new("NodeGroupOutput")
    for column, node in enumerate((entry, correction, move, leave)):
        node.location = (200.0 * column, -120.0 if node is correction else 0.0)
    links.new(entry.outputs[0], move.inputs["Geometry"])
    links.new(correction.outputs["Attribute"], move.inputs["Offset"])
    links.new(move.outputs["Geometry"], leave.inputs[0])
    return group
