# SPDX-License-Identifier: GPL-3.0-or-later
"""Shows a mesh as translucent: a Geometry Nodes modifier gives it a translucent material, in viewports only.

The material slots of the mesh stay as they are. Solid shading reads the alpha of the material's viewport color, the other
shadings its nodes. Renders, Edit Mode and exports that apply the modifiers of renders do not see it.
"""

import bpy

MODIFIER = "Sinew X-ray"
DEFAULT = (0.80, 0.58, 0.47, 0.2)  # linear red, green, blue and alpha
# alpha where the surface faces the view, and at its outline, over the alpha of the colour
_FACING, _OUTLINE = 0.5, 3.1
_GROUP, _MATERIAL = "Sinew X-ray", "Sinew Translucent Skin"
_MARK = "sinew_xray"

_colour = DEFAULT


def set_colour(colour: tuple[float, float, float, float]):
    """Changes the colour and alpha of the translucent skin, also in the material of the file."""
    global _colour
    _colour = colour
    for material in _own_materials():
        _write(material)


def modifier_of(mesh_object):
    """The modifier that makes a mesh translucent, or None. Its node group identifies it."""
    return next(
        (
            modifier
            for modifier in mesh_object.modifiers
            if modifier.type == "NODES" and modifier.node_group and modifier.node_group.get(_MARK)
        ),
        None,
    )


def show(mesh_object):
    """Makes a mesh translucent. Leaves an object alone that is linked from another file."""
    if mesh_object.library:
        return
    modifier = modifier_of(mesh_object)
    if modifier is None:
        modifier = mesh_object.modifiers.new(MODIFIER, "NODES")
        modifier.node_group = _group()
        modifier.show_render = modifier.show_in_editmode = modifier.show_expanded = False
    if not modifier.show_viewport:
        modifier.show_viewport = True


def rest(mesh_object):
    """Makes a mesh opaque until the next `show`. The modifier stays, so that the stack keeps its order."""
    modifier = modifier_of(mesh_object)
    if modifier and modifier.show_viewport:
        modifier.show_viewport = False


def remove(mesh_object):
    """Removes the modifier, and the node group and the material unless something else uses them."""
    modifier = modifier_of(mesh_object)
    if modifier and not mesh_object.library:
        mesh_object.modifiers.remove(modifier)
        remove_unused()


def remove_unused():
    """Removes the node group and the material if nothing uses them."""
    for found in (bpy.data.node_groups, bpy.data.materials):  # the group uses the material
        for datum in [datum for datum in found if datum.get(_MARK) and not datum.library and not datum.users]:
            found.remove(datum)


def _group():
    for tree in bpy.data.node_groups:
        if tree.get(_MARK) and not tree.library:
            return tree
    tree = bpy.data.node_groups.new(_GROUP, "GeometryNodeTree")
    tree[_MARK] = True
    tree.is_modifier = True
    for direction in ("INPUT", "OUTPUT"):
        tree.interface.new_socket("Geometry", in_out=direction, socket_type="NodeSocketGeometry")
    start, coloured, end = map(tree.nodes.new, ("NodeGroupInput", "GeometryNodeSetMaterial", "NodeGroupOutput"))
    coloured.inputs["Material"].default_value = _material()
    for column, node in enumerate((start, coloured, end)):
        node.location = (200.0 * column, 0.0)
    tree.links.new(start.outputs[0], coloured.inputs["Geometry"])
    tree.links.new(coloured.outputs[0], end.inputs[0])
    return tree


def _own_materials() -> list:
    # while Blender starts and enables the extension, there is no data yet
    return [material for material in getattr(bpy.data, "materials", ()) if material.get(_MARK) and not material.library]


def _material():
    for material in _own_materials():
        return material
    material = bpy.data.materials.new(_MATERIAL)
    material[_MARK] = True
    material.surface_render_method = "BLENDED"
    material.use_transparency_overlap = False  # the back of the skin would hide the muscles
    if material.node_tree is None:
        material.use_nodes = True
    nodes, links = material.node_tree.nodes, material.node_tree.links
    facing, alpha = nodes.new("ShaderNodeLayerWeight"), nodes.new("ShaderNodeMapRange")
    facing.inputs["Blend"].default_value = 0.5
    links.new(facing.outputs["Facing"], alpha.inputs["Value"])
    links.new(alpha.outputs["Result"], nodes["Principled BSDF"].inputs["Alpha"])
    _write(material)
    return material


def _write(material):
    material.diffuse_color = _colour
    nodes = material.node_tree.nodes
    shader, alpha = nodes.get("Principled BSDF"), next((node for node in nodes if node.type == "MAP_RANGE"), None)
    if shader and alpha:
        shader.inputs["Base Color"].default_value = (*_colour[:3], 1.0)
        for name, factor in (("To Min", _FACING), ("To Max", _OUTLINE)):
            alpha.inputs[name].default_value = min(factor * _colour[3], 1.0)
