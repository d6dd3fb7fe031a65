# SPDX-License-Identifier: GPL-3.0-or-later
"""The bind of a skin in a frame, with that of the body under it, whose correction a garment follows."""

from collections.abc import Callable

import numpy as np

from ..errors import SinewError
from ..scene import animated_value, armature_modifier, level_of_detail, stored_settings
from ..scene.level_of_detail import Detail
from . import session
from .edit_flags import EditScope
from .rig_cache import RigState
from .skin_cache import SkinState

DetailOf = Callable[[object], Detail]


def skin_state(
    depsgraph,
    rig,
    skin,
    rig_state: RigState,
    edited: EditScope = EditScope.ANYTHING,
    detail_of: DetailOf = level_of_detail.full,
) -> SkinState:
    """The bind of a mesh at its position in this evaluation, as `session.skin_state`, and its body's, if it has one.

    detail_of: gives the detail of a skin, from the object that has its settings in this evaluation.
    """
    body = _body_state(depsgraph, rig, skin, rig_state, edited, detail_of)
    to_armature = mesh_to_armature(depsgraph, rig, skin)
    detail = detail_of(animated_value.values_of(skin, depsgraph))
    return session.skin_state(skin, rig_state, to_armature, depsgraph, detail, edited, body)


def mesh_to_armature(depsgraph, rig, skin) -> np.ndarray:
    """(4, 4) float32, column-major: from mesh space to armature space in this evaluation."""
    evaluated_rig, evaluated_skin = rig.evaluated_get(depsgraph), skin.evaluated_get(depsgraph)
    relation = evaluated_rig.matrix_world.inverted_safe() @ evaluated_skin.matrix_world
    return np.array(relation.transposed(), np.float32, order="C")


def bodies_first(skins: list) -> list:
    """The skins of a character, each after the skin that it is worn over."""
    return sorted(skins, key=_depth)


def innermost(skin):
    """The mesh under all layers that a mesh is worn over; the mesh itself if it is worn over none."""
    return _layers_under(skin)[-1]


def _depth(skin) -> int:
    return len(_layers_under(skin))


def _layers_under(skin) -> list:
    """A mesh, the mesh that it is worn over, and so on. A circle ends where it closes."""
    layers = [skin]
    while (body := stored_settings.worn_over_of(layers[-1])) is not None and body not in layers:
        layers.append(body)
    return layers


def _body_state(depsgraph, rig, skin, rig_state: RigState, edited: EditScope, detail_of: DetailOf) -> SkinState | None:
    body = stored_settings.worn_over_of(skin)
    if body is None:
        return None
    where = f"{skin.name} is worn over {body.name}"
    if _is_under_itself(skin):
        raise SinewError(f"{where}, which is worn over {skin.name}. Clear Worn Over of one of them")
    if not armature_modifier.is_bound(body):
        raise SinewError(f"{where}, which is not bound. Bind it, or clear Worn Over")
    if armature_modifier.rig_of(body) != rig:
        raise SinewError(f"{where}, which follows another armature. Choose a mesh of {rig.name}, or clear Worn Over")
    if not body.evaluated_get(depsgraph).is_evaluated:
        raise SinewError(f"{where}, which is not part of this scene and view layer. Make it visible, or clear Worn Over")
    if body.data.is_editmode:
        raise SinewError(f"{where}, which is in Edit Mode. Leave it (Tab)")
    return skin_state(depsgraph, rig, body, rig_state, edited, detail_of)


def _is_under_itself(skin) -> bool:
    return stored_settings.worn_over_of(_layers_under(skin)[-1]) is not None
