# SPDX-License-Identifier: GPL-3.0-or-later
"""The Geometry Nodes that place an ellipsoid or a tendon on each point of a mesh, as the attributes of the point say.

The attribute SHAPE chooses what a point shows: first the ellipsoids in the colours of stretch, then the ellipsoids and
tendons in the colours of anatomy.
"""

import bpy

from . import anatomy_colours, stretch_colours

AXIS_X, AXIS_Z, SCALE, SHAPE = "sinew_axis_x", "sinew_axis_z", "sinew_scale", "sinew_step"
FIRST_OF_ANATOMY = stretch_colours.STEPS
_NAME = "Sinew Ellipsoids"
_MARK = "sinew_ellipsoids_group"
_VERSION = 2  # 1: stretch only (Sinew 0.2)
_SEGMENTS, _RINGS = 20, 12
_TENDON_SEGMENTS = 8


def group():
    """The node group of this file. Creates it if it is missing."""
    for tree in bpy.data.node_groups:
        if tree.get(_MARK) == _VERSION and not tree.library:
            return tree
    return _create()


def remove_unused():
    """Removes Sinew's node groups and materials that nothing uses."""
    for tree in [tree for tree in bpy.data.node_groups if tree.get(_MARK) and not tree.library and not tree.users]:
        bpy.data.node_groups.remove(tree)
    stretch_colours.remove_unused()
    anatomy_colours.remove_unused()


def _create():
    tree = bpy.data.node_groups.new(_NAME, "GeometryNodeTree")
    tree[_MARK] = _VERSION
    for direction in ("INPUT", "OUTPUT"):
        tree.interface.new_socket("Geometry", in_out=direction, socket_type="NodeSocketGeometry")
    nodes, links = tree.nodes, tree.links
    shapes = nodes.new("GeometryNodeJoinGeometry")
    made = [_sphere(tree, material) for material in stretch_colours.materials()]
    for number, material in enumerate(anatomy_colours.materials()):
        make = _tendon if number == anatomy_colours.TENDON else _sphere
        made.append(make(tree, material))
    # Join Geometry orders its inputs from the last link to the first
    for instance in reversed(made):
        links.new(instance, shapes.inputs[0])
    rotation = nodes.new("FunctionNodeAxesToRotation")
    rotation.primary_axis, rotation.secondary_axis = "Z", "X"
    links.new(_attribute(tree, AXIS_Z, "FLOAT_VECTOR"), rotation.inputs[0])
    links.new(_attribute(tree, AXIS_X, "FLOAT_VECTOR"), rotation.inputs[1])
    instances = nodes.new("GeometryNodeInstanceOnPoints")
    instances.inputs["Pick Instance"].default_value = True
    for socket, output in (
        ("Points", nodes.new("NodeGroupInput").outputs[0]),
        ("Instance", shapes.outputs[0]),
        ("Instance Index", _attribute(tree, SHAPE, "INT")),
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
    """A sphere of radius 1 around the point."""
    sphere = tree.nodes.new("GeometryNodeMeshUVSphere")
    sphere.inputs["Segments"].default_value, sphere.inputs["Rings"].default_value = _SEGMENTS, _RINGS
    return _as_instance(tree, sphere, material)


def _tendon(tree, material):
    """A tube of radius 1 and length 1 from the point along its z axis."""
    tube = tree.nodes.new("GeometryNodeMeshCone")
    tube.fill_type = "NONE"
    tube.inputs["Vertices"].default_value = _TENDON_SEGMENTS
    for name in ("Radius Bottom", "Radius Top", "Depth"):
        tube.inputs[name].default_value = 1.0
    return _as_instance(tree, tube, material)


def _as_instance(tree, shape, material):
    smooth, coloured, instance = map(
        tree.nodes.new, ("GeometryNodeSetShadeSmooth", "GeometryNodeSetMaterial", "GeometryNodeGeometryToInstance")
    )
    coloured.inputs["Material"].default_value = material
    for earlier, later in ((shape, smooth), (smooth, coloured), (coloured, instance)):
        tree.links.new(earlier.outputs[0], later.inputs[0])
    return instance.outputs[0]
