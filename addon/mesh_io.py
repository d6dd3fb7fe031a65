# SPDX-License-Identifier: GPL-3.0-or-later
"""The only reader and writer of skin meshes: rest points, edges and weights in, the correction out. (What a person paints
for Sinew on them is for `painted_io`.)

The correction is a vector attribute that a Geometry Nodes modifier, first in the stack, adds to the points before the
Armature modifier. Nothing else of the mesh is touched.
"""

from dataclasses import dataclass

import bpy
import numpy as np

from . import rig_io
from .errors import SinewError

CORRECTION_ATTRIBUTE = "sinew_correction"
MODIFIER = "Sinew"
CACHE_MODIFIER = "Sinew Cache"
NODE_GROUP = "Sinew Correction"
_GROUP_MARK = "sinew_correction_group"


@dataclass(frozen=True)
class BoneWeights:
    """A mesh's bone weights as the core takes them (CSR): see `_sinew.Skin`."""

    offsets: np.ndarray
    frames: np.ndarray
    weights: np.ndarray

    def __eq__(self, other) -> bool:
        return self is other or (
            np.array_equal(self.offsets, other.offsets)
            and np.array_equal(self.frames, other.frames)
            and np.array_equal(self.weights, other.weights)
        )


def is_bound(candidate) -> bool:
    """Whether an object is a mesh bound by Sinew; asks without leaving a trace on objects that are none of ours."""
    return candidate.type == "MESH" and candidate.is_property_set("sinew") and candidate.sinew.bound


def rig_of(skin):
    """The armature that moves a mesh: of its Armature modifier, else its parent. Raises SinewError where there is none."""
    modifiers = armature_modifiers(skin)
    _refuse_several(skin, modifiers)
    if modifiers:
        return modifiers[0].object
    if skin.parent and skin.parent.type == "ARMATURE":
        return skin.parent
    raise SinewError(f"{skin.name} follows no armature: parent it to one (Ctrl+P > With Automatic Weights) and bind again")


def _refuse_several(skin, modifiers: list):
    if len(modifiers) > 1:
        names = ", ".join(modifier.name for modifier in modifiers)
        raise SinewError(f"{skin.name} has several Armature modifiers ({names}): Sinew follows one; remove the others")


def armature_modifiers(skin) -> list:
    """The Armature modifiers of a mesh that have an armature."""
    return [modifier for modifier in skin.modifiers if modifier.type == "ARMATURE" and modifier.object]


def skinning_of(skin) -> str:
    """What the Armature modifier does, in the core's words. Raises SinewError for what Sinew does not follow."""
    modifiers = armature_modifiers(skin)
    _refuse_several(skin, modifiers)
    if skin.parent_type == "ARMATURE" and skin.parent and skin.parent.type == "ARMATURE":
        # Blender then deforms the mesh before its first modifier, where no correction comes before it
        raise SinewError(
            f"{skin.name} is deformed by its parent type 'Armature', which Sinew can't come before: "
            "make the parent type 'Object' and add an Armature modifier (Ctrl+P > Armature Deform)"
        )
    if not modifiers:
        return "NONE"
    modifier = modifiers[0]
    where = f"{skin.name}: Armature modifier '{modifier.name}'"
    if modifier.use_bone_envelopes:
        raise SinewError(f"{where} uses Bone Envelopes, which Sinew does not follow: switch them off or paint weights")
    if modifier.use_multi_modifier:
        raise SinewError(f"{where} has Multi Modifier on, which Sinew does not follow: switch it off")
    if modifier.vertex_group and modifier.use_deform_preserve_volume:
        raise SinewError(f"{where} has a vertex group and Preserve Volume: Sinew follows one of them; clear the other")
    if not modifier.use_vertex_groups:
        return "NONE"
    return "PRESERVE_VOLUME" if modifier.use_deform_preserve_volume else "LINEAR"


def follows_armature(skin, mode: str) -> bool:
    """Whether the Armature modifier is on in an evaluation of this mode ('VIEWPORT' or 'RENDER')."""
    shown = "show_render" if mode == "RENDER" else "show_viewport"
    return all(getattr(modifier, shown) for modifier in armature_modifiers(skin))


def modifier_state(skin) -> tuple:
    """The settings of a mesh's Armature modifiers that its bind depends on."""
    return tuple(
        (
            modifier.use_deform_preserve_volume,
            modifier.use_vertex_groups,
            modifier.use_bone_envelopes,
            modifier.use_multi_modifier,
            modifier.vertex_group,
            modifier.invert_vertex_group,
        )
        for modifier in armature_modifiers(skin)
    )


def read_points(mesh) -> np.ndarray:
    """(vertices, 3) float32: the rest points, mesh space; of the basis where the mesh has shape keys."""
    points = np.empty((len(mesh.vertices), 3), np.float32)
    keys = mesh.shape_keys
    if keys:
        keys.reference_key.points.foreach_get("co", points.reshape(-1))
    else:
        mesh.attributes["position"].data.foreach_get("vector", points.reshape(-1))
    return points


def read_edges(mesh) -> np.ndarray:
    """(edges, 2) int32."""
    edges = np.empty((len(mesh.edges), 2), np.int32)
    mesh.edges.foreach_get("vertices", edges.reshape(-1))
    return edges


def read_triangles(mesh) -> np.ndarray:
    """(triangles, 3) int32: the faces, cut as Blender cuts them."""
    mesh.calc_loop_triangles()
    triangles = np.empty((len(mesh.loop_triangles), 3), np.int32)
    mesh.loop_triangles.foreach_get("vertices", triangles.reshape(-1))
    return triangles


def read_struts(mesh, edges: np.ndarray) -> np.ndarray:
    """(struts, 2) int32: the edges, and both diagonals of every face of four corners; they stiffen it against shear."""
    starts, sizes = np.empty(len(mesh.polygons), np.int32), np.empty(len(mesh.polygons), np.int32)
    mesh.polygons.foreach_get("loop_start", starts)
    mesh.polygons.foreach_get("loop_total", sizes)
    corners = np.empty(len(mesh.loops), np.int32)
    mesh.loops.foreach_get("vertex_index", corners)
    first = starts[sizes == 4]
    diagonals = [np.stack((corners[first + a], corners[first + b]), axis=1) for a, b in ((0, 2), (1, 3))]
    return np.ascontiguousarray(np.concatenate((edges, *diagonals)))


def read_weights(skin, rest: rig_io.RigRest, mesh_to_armature) -> BoneWeights:
    """The weights of the bones that the Armature modifier of `skin` uses; none without such a modifier.

    A B-Bone's weight is shared between its two nearest joints and, where the modifier has a vertex group, a vertex's
    remainder goes to the armature itself, so that linear skinning of the frames is what Blender does.
    """
    modifiers = armature_modifiers(skin)
    frame_of_group, bendy_of_group = {}, {}
    if modifiers and modifiers[0].use_vertex_groups:
        for group in skin.vertex_groups:
            if group.name in rest.deforming:
                frame_of_group[group.index] = rest.frame_of_bone[group.name]
                bendy = rest.bendy_bone(group.name)
                if bendy:
                    bendy_of_group[group.index] = bendy
    mask = skin.vertex_groups.get(modifiers[0].vertex_group) if modifiers else None
    mask_index = mask.index if mask else None
    inverted = bool(mask) and modifiers[0].invert_vertex_group
    pose_bones = rig_of(skin).pose.bones if bendy_of_group else None

    offsets, frames, weights = [0], [], []
    for vertex in skin.data.vertices:
        first, share = len(frames), 0.0
        for element in vertex.groups:
            group, weight = element.group, element.weight
            if group == mask_index:
                share = weight
            if weight <= 0.0 or group not in frame_of_group:
                continue
            bendy = bendy_of_group.get(group)
            if bendy is None:
                frames.append(frame_of_group[group])
                weights.append(weight)
            else:
                joint, blend = pose_bones[bendy.name].bbone_segment_index(mesh_to_armature @ vertex.co)
                frames += (bendy.first + joint, bendy.first + joint + 1)
                weights += (weight * (1.0 - blend), weight * blend)
        if mask is not None:
            _mask(frames, weights, first, 1.0 - share if inverted else share, rest.armature_frame)
        offsets.append(len(frames))
    return BoneWeights(np.array(offsets, np.int32), np.array(frames, np.int32), np.array(weights, np.float32))


def _mask(frames: list, weights: list, first: int, share: float, armature_frame: int):
    total = sum(weights[first:])
    if total <= 0.0:
        return
    weights[first:] = [weight / total * share for weight in weights[first:]]
    frames.append(armature_frame)
    weights.append(1.0 - share)


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
        other.data == skin.data and other != skin and modifier_of(other) for other in bpy.data.objects if other.type == "MESH"
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


def cache_modifier_of(skin):
    """The Mesh Cache modifier that plays what Sinew baked into a file, however it was renamed or moved; or None.

    On a library override, Blender makes added modifiers anew as it loads, with other identifiers: there the name counts.
    """
    uid = skin.sinew.cache_modifier
    caches = [modifier for modifier in skin.modifiers if uid and modifier.type == "MESH_CACHE"]
    same = [modifier for modifier in caches if modifier.persistent_uid == uid]
    named = [modifier for modifier in caches if modifier.name == CACHE_MODIFIER]
    return next(iter(same or named), None)


def show_live(skin):
    """Lets either the live correction or what was baked (shape keys, a point cache) act, never both, as
    `skin.sinew.live` says."""
    live = skin.sinew.live
    for modifier, shown in ((modifier_of(skin), live), (cache_modifier_of(skin), not live)):
        if modifier:
            modifier.show_viewport = shown
            modifier.show_render = shown
    keys = skin.data.shape_keys if skin.type == "MESH" else None
    if keys:
        for baked in skin.sinew.baked_keys:
            key = keys.key_blocks.get(baked.name)
            if key:
                key.mute = live or baked.silenced


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


def read_evaluated_points(mesh) -> np.ndarray:
    """(vertices, 3) float32: the points of a mesh as its modifiers left them, object space."""
    points = np.empty((len(mesh.vertices), 3), np.float32)
    if len(points):
        mesh.attributes["position"].data.foreach_get("vector", points.reshape(-1))
    return points
