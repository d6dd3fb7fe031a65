# SPDX-License-Identifier: GPL-3.0-or-later
"""The correction of a mesh: the vector attribute that holds it, and the modifier that adds it.

The modifier is a Geometry Nodes modifier at the top of the stack, or as near to it as Blender allows (`modifier_stack`). It
adds the attribute to the points before the Armature modifier (docs/mathematics/correction.md, Correction). Nothing else of
the mesh changes.
"""

import bpy
import numpy as np

from ..errors import SinewError

CORRECTION_ATTRIBUTE = "sinew_correction"
MODIFIER = "Sinew"
NODE_GROUP = "Sinew Correction"
_GROUP_MARK = "sinew_correction_group"


def add_correction(skin, position: int = 0):
    """Adds the correction attribute, 0 everywhere, and the modifier, if it is missing, at a position in the stack."""
    _attribute(skin.data)
    if modifier_of(skin) is None:
        modifier = skin.modifiers.new(MODIFIER, "NODES")
        modifier.node_group = _node_group()
        modifier.show_in_editmode = False
        modifier.show_expanded = False
        skin.modifiers.move(skin.modifiers.find(modifier.name), position)


def remove_correction(skin):
    """Removes the modifier, and the attribute and the node group unless something else uses them."""
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


def remove_unused():
    """Removes the correction from meshes without Sinew's modifier, and the node group if nothing uses it.

    Joining a bound mesh into another one leaves both.
    """
    used = {found.data.session_uid for found in bpy.data.objects if found.type == "MESH" and modifier_of(found)}
    for mesh in bpy.data.meshes:
        attribute = mesh.attributes.get(CORRECTION_ATTRIBUTE)
        if attribute and mesh.session_uid not in used and mesh.library is None and not mesh.is_editmode:
            mesh.attributes.remove(attribute)
    for group in list(bpy.data.node_groups):
        if group.get(_GROUP_MARK) and group.users == 0 and group.library is None:
            bpy.data.node_groups.remove(group)


def modifier_of(skin):
    """Sinew's modifier on a mesh, or None. Its node group identifies it, so it may have any name."""
    return next(
        (
            modifier
            for modifier in skin.modifiers
            if modifier.type == "NODES" and modifier.node_group and is_correction_group(modifier.node_group)
        ),
        None,
    )


def is_correction_group(group) -> bool:
    """Whether a node group is that of Sinew's modifier."""
    return bool(group.get(_GROUP_MARK))


def has_correction(mesh) -> bool:
    """Whether the mesh has the correction attribute, as a vector per vertex."""
    attribute = mesh.attributes.get(CORRECTION_ATTRIBUTE)
    return attribute is not None and _holds_corrections(attribute)


def read_correction(mesh, out: np.ndarray) -> bool:
    """Copies the mesh's correction into `out`, (vertices, 3) float32. Returns False if the mesh has none of this size."""
    attribute = mesh.attributes.get(CORRECTION_ATTRIBUTE)
    if attribute is None or len(attribute.data) != len(out):
        return False
    try:
        attribute.data.foreach_get("vector", out.reshape(-1))
    except (AttributeError, RuntimeError, TypeError):
        return False  # the user converted it to another type; reading the type in each frame would cost more
    return True


def write_correction(mesh, correction: np.ndarray):
    """Writes the correction, (vertices, 3) float32 in mesh space. Blender then evaluates the mesh again.

    On a linked mesh (of a library override) the correction exists in memory only, and is not saved.
    """
    data = _attribute(mesh).data
    if mesh.library is None:
        data.foreach_set("vector", correction.reshape(-1))
        return
    # foreach_set silently skips linked data; single values can be set
    current = np.empty_like(correction)
    data.foreach_get("vector", current.reshape(-1))
    for vertex in np.flatnonzero((current != correction).any(axis=1)).tolist():
        data[vertex].vector = correction[vertex]


def _holds_corrections(attribute) -> bool:
    """Whether an attribute is a vector per vertex. The user may have converted it."""
    return attribute.domain == "POINT" and attribute.data_type == "FLOAT_VECTOR"


def _attribute(mesh):
    attribute = mesh.attributes.get(CORRECTION_ATTRIBUTE)
    if attribute and not _holds_corrections(attribute):
        raise SinewError(f"{mesh.name}: attribute '{CORRECTION_ATTRIBUTE}' is not a vector per vertex. Remove or rename it")
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
    group_input = nodes.new("NodeGroupInput")
    correction = nodes.new("GeometryNodeInputNamedAttribute")
    correction.data_type = "FLOAT_VECTOR"
    correction.inputs["Name"].default_value = CORRECTION_ATTRIBUTE
    set_position = nodes.new("GeometryNodeSetPosition")
    group_output = nodes.new("NodeGroupOutput")
    for column, node in enumerate((group_input, correction, set_position, group_output)):
        node.location = (200.0 * column, -120.0 if node is correction else 0.0)
    links.new(group_input.outputs[0], set_position.inputs["Geometry"])
    links.new(correction.outputs["Attribute"], set_position.inputs["Offset"])
    links.new(set_position.outputs["Geometry"], group_output.inputs[0])
    return group
