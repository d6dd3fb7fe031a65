# SPDX-License-Identifier: GPL-3.0-or-later
"""Which modifiers a mesh may have around Sinew's, and where Sinew's modifier goes.

The correction belongs to the vertices of the mesh, and the Armature modifier must follow it. So a modifier before the
Armature modifier must not make vertices that move with other bones than the vertex they come from, and must make the same
vertices in every frame.
"""

from ..errors import SinewError
from . import armature_modifier, correction_modifier

# Blender lets only deforming modifiers before these.
_FIRST = ("MULTIRES", "SOFT_BODY")
_COPIES = "its copies would get the correction of the half or part that they are copied from"
_REBUILDS = "it builds another mesh in every frame, to which the correction does not belong"
_WHY_REFUSED = {
    "MIRROR": _COPIES,
    "ARRAY": _COPIES,
    "SCREW": _COPIES,
    "BOOLEAN": _REBUILDS,
    "BUILD": _REBUILDS,
    "DECIMATE": _REBUILDS,
    "EXPLODE": _REBUILDS,
    "FLUID": _REBUILDS,
    "OCEAN": _REBUILDS,
    "MESH_TO_VOLUME": _REBUILDS,
    "VOLUME_TO_MESH": _REBUILDS,
    "PARTICLE_INSTANCE": _REBUILDS,
    "REMESH": _REBUILDS,
    "SKIN": _REBUILDS,
}
# nodes whose output has the vertices of their input, or none at all
_KEEPS_VERTICES = frozenset(
    (
        "GeometryNodeSetPosition", "GeometryNodeStoreNamedAttribute", "GeometryNodeRemoveAttribute",
        "GeometryNodeSetShadeSmooth", "GeometryNodeSetMaterial", "GeometryNodeSetMaterialIndex",
        "GeometryNodeReplaceMaterial", "GeometryNodeSetID", "GeometryNodeSetMeshNormal", "GeometryNodeCaptureAttribute",
        "GeometryNodeSwitch", "GeometryNodeMenuSwitch", "GeometryNodeIndexSwitch", "GeometryNodeSetGeometryName",
        "GeometryNodeWarning", "GeometryNodeGroup", "NodeGroupInput", "NodeReroute",
    )
)  # fmt: skip


def check(skin):
    """Raises SinewError, with what to do, if the mesh has modifiers with which no correction can be right."""
    for modifier in _before_armature(skin):
        why = _why_refused(modifier)
        if why:
            raise SinewError(
                f"{skin.name}: the modifier '{modifier.name}' acts before the Armature modifier, and {why}. Apply it "
                "(arrow in its header > Apply), or move it below the Armature modifier"
            )
    blocking = [modifier for modifier in _from_armature(skin) if modifier.type in _FIRST]
    if blocking and correction_modifier.modifier_of(skin) is None:
        name = blocking[0].name
        raise SinewError(
            f"{skin.name}: Blender allows no new modifier before '{name}', so Sinew can't come before the Armature "
            f"modifier. Move '{name}' above the Armature modifier"
        )


def check_order(skin):
    """Raises SinewError if Sinew's modifier is not before the Armature modifiers, or another one now prevents its work."""
    ours = correction_modifier.modifier_of(skin)
    for modifier in skin.modifiers:
        if modifier == ours:
            break
        if modifier.type == "ARMATURE" and modifier.object:
            raise SinewError(
                f"{skin.name}: the modifier '{ours.name}' is below '{modifier.name}', where its correction is wrong. "
                "Move it above"
            )
    check(skin)


def position(skin) -> int:
    """The index in the stack for Sinew's modifier: 0, or after a modifier that must be first."""
    first = [index for index, modifier in enumerate(skin.modifiers) if modifier.type in _FIRST]
    armatures = [skin.modifiers.find(modifier.name) for modifier in armature_modifier.armature_modifiers(skin)]
    before = [index for index in first if not armatures or index < armatures[0]]
    return before[-1] + 1 if before else 0


def _before_armature(skin):
    """The modifiers that are on and act on what the Armature modifier then moves; all, if the mesh has none."""
    for modifier in skin.modifiers:
        if modifier.type == "ARMATURE" and modifier.object:
            return
        if modifier.show_viewport or modifier.show_render:
            yield modifier


def _from_armature(skin) -> list:
    kinds = [modifier.type == "ARMATURE" and modifier.object is not None for modifier in skin.modifiers]
    return list(skin.modifiers)[kinds.index(True) :] if True in kinds else []


def _why_refused(modifier) -> str:
    if modifier.type != "NODES":
        return _WHY_REFUSED.get(modifier.type, "")
    group = modifier.node_group
    if group is None or correction_modifier.is_correction_group(group):
        return ""
    node = _node_that_makes_vertices(group, set())
    return f"its node '{node}' can make other vertices, to which the correction does not belong" if node else ""


def _node_that_makes_vertices(group, seen: set[str]) -> str:
    """The label of a node that is not known to keep the vertices; an empty text if there is none."""
    seen.add(group.name)
    for node in group.nodes:
        if not any(socket.type == "GEOMETRY" and socket.is_linked for socket in node.outputs):
            continue
        if node.bl_idname not in _KEEPS_VERTICES:
            return node.label or node.bl_label
        inner = node.node_tree if node.bl_idname == "GeometryNodeGroup" else None
        if inner is not None and inner.name not in seen:
            found = _node_that_makes_vertices(inner, seen)
            if found:
                return found
    return ""
