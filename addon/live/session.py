# SPDX-License-Identifier: GPL-3.0-or-later
"""The live Rust objects: made from what stands in the file, dropped on load and undo, made anew when it changed.

Nothing here is a source of truth. Whether a kept object still fits is asked of the file at every frame (positions,
transforms, settings), except for what Blender gives no cheap look at: bone weights and what is painted are read again
after Blender reported a change of that mesh (`mark_weights_dirty`), settings of bones after one was changed
(`forget_bone_settings`). Where Blender says that nothing was edited since the last frame (`handlers`), only what can
change without an edit is asked for: what is animated, and the transforms of Empties.
"""

import numpy as np
from mathutils import Matrix

from ..scene import bone_weights, characters, mesh_arrays, painted_data, rig_pose, tissue_display
from . import tissue_snapshot
from .edit_flags import EditScope
from .rig_cache import RigState, read_musculature
from .skin_cache import SkinState, bind, bind_settings, weighing_of

_rigs: dict[int, RigState] = {}
_skins: dict[int, SkinState] = {}
_reasons: dict[int, str] = {}


def forget():
    """Drops everything, as on load, undo and redo."""
    _rigs.clear()
    _skins.clear()
    _reasons.clear()


def forget_skin(skin):
    """Drops one mesh's bind."""
    _skins.pop(skin.session_uid, None)
    _reasons.pop(skin.session_uid, None)


def forget_rig(rig):
    """Drops a rig's rest pose and musculature, as while it is in Edit Mode."""
    _rigs.pop(rig.session_uid, None)


def forget_bone_settings(rig):
    """A setting of a rig's bones was changed: they are read again at the next frame."""
    if rig.session_uid in _rigs:
        _rigs[rig.session_uid].bone_settings = None


def mark_rigs_dirty():
    """A setting was changed: all that tissues depend on is compared at the next frame."""
    for state in _rigs.values():
        state.character_index = None


def mark_weights_dirty(skin):
    """Blender reported a change of the mesh: weights and what is painted are compared at the next frame."""
    if skin.session_uid in _skins:
        _skins[skin.session_uid].suspect = True


def pin_bind(skin, state: SkinState):
    """Makes a bind of an earlier frame the one that the next frame begins with.

    A bind stands while the mesh stays in its place up to rounding, so which of two such binds a frame meets depends on
    the frames before it; a bake in chunks has to begin each frame with the same one.
    """
    _skins[skin.session_uid] = state


def kept_rig(rig) -> RigState | None:
    """The state of a rig as the last frame left it."""
    return _rigs.get(rig.session_uid)


def kept_skin(skin) -> SkinState | None:
    """The state of a mesh as the last frame left it, for display."""
    return _skins.get(skin.session_uid)


def reason(carrier) -> str:
    """Why a bound mesh does not follow its tissues at the moment, or an empty text."""
    return _reasons.get(carrier.session_uid, "")


def set_reason(carrier, text: str):
    _reasons.pop(carrier.session_uid, None)
    if text:
        _reasons[carrier.session_uid] = text


def rig_state(rig, tissues: list, vias: list | None = None, edited: EditScope = EditScope.ANYTHING) -> RigState:
    """The state of a rig with these tissues, made anew where the file changed. Raises ValueError of the core.

    vias: the Empties of its muscles' via points, in the order of their names; None looks for them. edited: since the last
    frame; not all of the file is then looked at.
    """
    state = _rigs.get(rig.session_uid)
    if (
        state
        and EditScope.ANY_DATA not in edited
        and state.character_index is characters.cached()
        and state.still_fits(rig, tissues, edited)
    ):
        if state.bone_settings is None:
            state.bone_settings = rig_pose.read_bone_settings(rig, state.rest)
        return state
    known = characters.current()
    vias = characters.vias_of(rig) if vias is None else vias
    if state and not state.has_rest_of(rig):
        state = None
    if state and state.bone_settings is None:
        state.bone_settings = rig_pose.read_bone_settings(rig, state.rest)
    settings = tissue_snapshot.settings_of(tissues) + tissue_snapshot.via_settings_of(vias)
    empties = tissues + vias
    animated = tissue_snapshot.animated(empties)
    is_any_disabled = any(empty.hide_viewport for empty in empties)
    rows = state.tissue_rows if state and state.character_index is known else tissue_snapshot.rows_of(empties)
    transforms = tissue_snapshot.transforms_of(rows)
    if state and state.tissue_settings == settings and np.array_equal(state.tissue_transforms, transforms):
        state.character_index, state.tissue_rows, state.animated = known, rows, animated
        state.is_any_disabled = is_any_disabled
        return state
    rest = state.rest if state else rig_pose.read_rest(rig)
    musculature, solved, problems = read_musculature(rig, rest, tissues, vias)
    state = RigState(
        rest=rest,
        tissue_settings=settings,
        tissue_rows=rows,
        tissue_transforms=transforms,
        musculature=musculature,
        solved=solved,
        problems=problems,
        character_index=known,
        animated=animated,
        is_any_disabled=is_any_disabled,
        shown=tissue_display.TissueDisplay(rig, rest, [tissues[place] for place in solved]),
        pose=np.empty((len(rest.skeleton), 4, 4), np.float32),
        tension=np.empty(len(solved), np.float32),
        posed=np.empty((len(solved), 4, 4), np.float32),
        bone_settings=state.bone_settings if state else rig_pose.read_bone_settings(rig, rest),
    )
    _rigs[rig.session_uid] = state
    return state


def forget_shown():
    """Nothing of what the Empties show can be relied on any more: the next frame shows all of them again."""
    for state in _rigs.values():
        state.shown.forget()


def skin_state(skin, rig: RigState, mesh_to_armature: np.ndarray, edited: EditScope = EditScope.ANYTHING) -> SkinState:
    """The bind of a mesh to its rig's tissues, made anew where mesh, tissues, weights or settings changed.

    mesh_to_armature: (4, 4) float32, column-major. edited: as for `rig_state`. Raises SinewError or ValueError (of the
    core) where it can't be bound.
    """
    mesh = skin.data
    state = _skins.get(skin.session_uid)
    if state and EditScope.ANY_DATA not in edited and not skin.animation_data and state.fits(mesh, rig, mesh_to_armature):
        return state
    settings, weighing = bind_settings(skin, rig.rest.size), weighing_of(skin)
    points = mesh_arrays.read_points(mesh)
    if state and not state.is_of_same_mesh(mesh, points, weighing, rig.rest, mesh_to_armature):
        state = None
    if state and not state.suspect:
        weights, painted = state.weights, state.painted
    else:
        place = state.mesh_to_armature if state else mesh_to_armature
        weights = bone_weights.read_weights(skin, rig.rest, Matrix(place.T.tolist()))
        painted = painted_data.read(skin)
    if state:
        state.suspect = False
        if (
            state.musculature is rig.musculature
            and state.settings == settings
            and state.bone_settings is rig.bone_settings
            and state.weights == weights
            and _same_arrays(state.painted, painted)
        ):
            return state
    # anew, with the weights that are there where only settings or tissues changed: reading them takes as long as the bind
    edges = mesh_arrays.read_edges(mesh)
    state = SkinState(
        rest=rig.rest,
        musculature=rig.musculature,
        mesh_uid=mesh.session_uid,
        points=points,
        edge_count=len(edges),
        mesh_to_armature=mesh_to_armature,
        settings=settings,
        weighing=weighing,
        weights=weights,
        bone_settings=rig.bone_settings,
        painted=painted,
        skin=bind(skin, rig, points, edges, mesh_to_armature, weights, painted),
        correction=np.zeros_like(points),
        present=np.empty_like(points),
    )
    _skins[skin.session_uid] = state
    return state


def _same_arrays(kept: dict[str, np.ndarray], now: dict[str, np.ndarray]) -> bool:
    return kept is now or kept.keys() == now.keys() and all(np.array_equal(kept[name], now[name]) for name in kept)
