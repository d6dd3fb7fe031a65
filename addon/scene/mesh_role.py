# SPDX-License-Identifier: GPL-3.0-or-later
"""Whether a mesh of a character is skin or cloth, or a rigid thing that one bone moves: an eye, a tooth, a hat.

Muscles are fitted under skin and cloth, and Bind Skin on an armature binds these. Rigid things stay as they are.
"""

import numpy as np

from . import armature_modifier, bone_geometry, mesh_arrays

LARGEST_SECOND_WEIGHT = 0.01  # of a vertex's weights, up to which it counts as moved by one bone


def soft_and_rigid(meshes: list, rig) -> tuple[list, dict[str, str]]:
    """The meshes that are skin or cloth, and why the others are not: a sentence by name. All must follow `rig`.

    If some have bone weights, a mesh without any is left out, too: it follows the armature as a whole.
    """
    bones = {mesh_object.name: _bone_of_vertices(mesh_object, rig) for mesh_object in meshes}
    reasons = {mesh_object.name: _why_rigid(mesh_object, rig, bones[mesh_object.name]) for mesh_object in meshes}
    soft = [mesh_object for mesh_object in meshes if not reasons[mesh_object.name]]
    weighted = [mesh_object for mesh_object in soft if _has_weights(bones[mesh_object.name])]
    if weighted:
        reasons |= {mesh_object.name: "has no bone weights" for mesh_object in soft if mesh_object not in weighted}
    return weighted or soft, {name: f"{name} {reason}" for name, reason in reasons.items() if reason}


def _why_rigid(mesh_object, rig, bones: np.ndarray | None) -> str:
    """Why a mesh is rigid, as the rest of a sentence; an empty text for skin and cloth.

    Rigid are meshes that a bone is the parent of, and meshes whose connected pieces are moved by one bone each. Meshes
    without any weights are not: the tissues can move these.
    """
    if mesh_object.parent == rig and mesh_object.parent_type == "BONE":
        return f"is parented to the bone {mesh_object.parent_bone}"
    if bones is None or not _has_weights(bones):
        return ""
    edges = mesh_arrays.read_edges(mesh_object.data)
    if (bones[edges[:, 0]] != bones[edges[:, 1]]).any():
        return ""
    names = [mesh_object.vertex_groups[index].name for index in np.unique(bones[bones >= 0]).tolist()]
    if len(names) == 1:
        return f"has all its weight on the bone {names[0]}"
    return f"consists of rigid pieces with one bone each ({', '.join(names[:3])}{', ...' if len(names) > 3 else ''})"


def _has_weights(bones: np.ndarray | None) -> bool:
    return bones is None or bool((bones >= 0).any())


def _bone_of_vertices(mesh_object, rig) -> np.ndarray | None:
    """(vertices,): the vertex group of the bone that moves each vertex, or -1. None if several bones move one vertex."""
    modifiers = armature_modifier.armature_modifiers(mesh_object)
    bones = np.full(len(mesh_object.data.vertices), -1, np.int32)
    if not any(modifier.use_vertex_groups for modifier in modifiers):
        return bones
    of_bones = {
        group.index
        for group in mesh_object.vertex_groups
        if bone_geometry.has_bone(rig, group.name) and rig.data.bones[group.name].use_deform
    }
    for index, vertex in enumerate(mesh_object.data.vertices):
        weights = [(element.weight, element.group) for element in vertex.groups if element.group in of_bones]
        if not weights:
            continue
        largest, group = max(weights)
        total = sum(weight for weight, _group in weights)
        if total - largest > LARGEST_SECOND_WEIGHT * total:
            return None
        if largest > 0.0:
            bones[index] = group
    return bones
