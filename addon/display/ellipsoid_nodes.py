# SPDX-License-Identifier: GPL-3.0-or-later
"""The Geometry Nodes that place an ellipsoid on each point of a mesh, with the axes and color of the point's attributes."""

import bpy

from . import stretch_colours

AXIS_X, AXIS_Z, SCALE, STEP = "sinew_axis_x", "sinew_axis_z", "sinew_scale", "sinew_step"
_NAME = "Sinew Ellipsoids"
_MARK = "sinew_ellipsoids_group"
_SEGMENTS, _RINGS = 20, 12


def group():
    """The node group of this file. Creates it if it is missing."""
    for tree in bpy.data.node_groups:
        if tree.get(_MARK) and not tree.library:
            return tree
    return _create()


def remove_unused():
    """Removes Sinew's node groups and materials that nothing uses."""
    for tree in [tree for tree in bpy.data.node_groups if tree.get(_MARK) and not tree.library and not tree.users]:
        bpy.data.node_groups.remove(tree)
    stretch_colours.remove_unused()


def _create():
    tree = bpy.data.node_groups.new(_NAME, "GeometryNodeTree")
    tree[_MARK] = True
    for direction in ("INPUT", "OUTPUT"):
        tree.interface.new_socket("Geometry", in_out=direction, socket_type="NodeSocketGeometry")
    nodes, links = tree.nodes, tree.links
    spheres = nodes.new("GeometryNodeJoinGeometry")
    # Join Geometry orders its inputs from the last link to the first
    for material in reversed(stretch_colours.materials()):
        links.new(_sphere(tree, material), spheres.inputs[0])
    rotation = nodes.new("FunctionNodeAxesToRotation")
    rotation.primary_axis, rotation.secondary_axis = "Z", "X"
    links.new(_attribute(tree, AXIS_Z, "FLOAT_VECTOR"), rotation.inputs[0])
    links.new(_attribute(tree, AXIS_X, "FLOAT_VECTOR"), rotation.inputs[1])
    instances = nodes.new("GeometryNodeInstanceOnPoints")
    instances.inputs["Pick Instance"].default_value = True
    for socket, output in (
        ("Points", nodes.new("NodeGroupInput").outputs[0]),
        ("Instance", spheres.outputs[0]),
        ("Instance Index", _attribute(tree, STEP, "INT")),
        ("Rotation", rotation.outputs[0]),
        ("Scale", _attribute(tree, SCALE, "FLOAT_VECTOR")),
    ):
        links.new(output, instances.inputs[socket])
    links.new(instances.outputs[0], nodes.new("NodeGroupOutput").inputs[0])
    return tree


def _attribute(tree, name: str, data_type: str):
    node = tree.nodes.new("GeometryNodeInputNamedAttribute")
    node.data_type = data_type
    node.inputs["Name"].default_value = name
    return node.outputs["Attribute"]


def _sphere(tree, material):
    sphere, smooth, coloured, instance = map(
        tree.nodes.new,
        (
            "GeometryNodeMeshUVSphere",
            "GeometryNodeSetShadeSmooth",
            "GeometryNodeSetMaterial",
            "GeometryNodeGeometryToInstance",
        ),
    )
    sphere.inputs["Segments"].default_value, sphere.inputs["Rings"].default_value = _SEGMENTS, _RINGS
    coloured.inputs["Material"].default_value = material
    for earlier, later in ((sphere, smooth), (smooth, coloured), (coloured, instance)):
        tree.links.new(earlier.outputs[0], later.inputs[0])
    return instance.outputs[0]
