# SPDX-License-Identifier: GPL-3.0-or-later
"""The cache of this session: the core's musculatures and binds, made from the file and dropped on load and undo.

The cache is never a source of truth. Each frame compares positions, transforms and settings with the file, and what changed
is made again. Some data is too slow to compare in each frame. Bone weights and painted factors are read again after Blender
reports a change of the mesh (`mark_weights_dirty`), and settings of bones after one of them changed
(`forget_bone_settings`). If Blender reports no edit since the last frame (`handlers`), a frame compares only what can
change without an edit: animated values, and the transforms of Empties.
"""

import numpy as np
from mathutils import Matrix

from ..scene import bone_weights, characters, mesh_arrays, mixing, painted_data, rig_pose, tissue_display
from . import tissue_snapshot
from .edit_flags import EditScope
from .rig_cache import RigState, read_musculature
from .skin_cache import SkinState, bind, bind_settings, weight_sources_of

_rigs: dict[int, RigState] = {}
_skins: dict[int, SkinState] = {}
_reasons: dict[int, str] = {}


def forget():
    """Drops everything, on load, undo and redo."""
    _rigs.clear()
    _skins.clear()
    _reasons.clear()


def forget_skin(skin):
    """Drops the bind of a mesh."""
    _skins.pop(skin.session_uid, None)
    _reasons.pop(skin.session_uid, None)


def forget_rig(rig):
    """Drops the rest pose and musculature of a rig, while it is in Edit Mode."""
    _rigs.pop(rig.session_uid, None)


def forget_bone_settings(rig):
    """A setting of a rig's bones changed: the next frame reads them again."""
    if rig.session_uid in _rigs:
        _rigs[rig.session_uid].bone_settings = None


def mark_rig_dirty(rig):
    """A setting of a rig, its tissues or its skins changed: the next frame compares everything that they depend on."""
    if rig.session_uid in _rigs:
        _rigs[rig.session_uid].character_index = None


def mark_weights_dirty(skin):
    """Blender reported a change of the mesh: the next frame reads its weights and painted factors again."""
    if skin.session_uid in _skins:
        _skins[skin.session_uid].is_dirty = True


def pin_bind(skin, state: SkinState):
    """Makes the next frame start with a bind of an earlier frame.

    A bind is kept while the mesh moves only by rounding, so binds of different frames differ by rounding. With one pinned
    bind, all chunks of a farm bake start from the same.
    """
    _skins[skin.session_uid] = state


def cached_rig(rig) -> RigState | None:
    """The state of a rig in the last frame, or None."""
    return _rigs.get(rig.session_uid)


def cached_skin(skin) -> SkinState | None:
    """The state of a mesh in the last frame, or None."""
    return _skins.get(skin.session_uid)


def reason(skin) -> str:
    """Why a bound mesh does not follow its tissues now, or an empty text."""
    return _reasons.get(skin.session_uid, "")


def set_reason(skin, text: str) -> str:
    """Sets or, with an empty text, clears the reason. Returns the reason before."""
    before = _reasons.pop(skin.session_uid, "")
    if text:
        _reasons[skin.session_uid] = text
    return before


def rig_state(rig, tissues: list, vias: list | None = None, edited: EditScope = EditScope.ANYTHING) -> RigState:
    """The state of a rig with these tissues, updated if the file changed. Raises ValueError from the core.

    vias: the Empties of its muscles' via points, sorted by name. None searches for them. edited: what was edited since the
    last frame; other data is not compared.
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
    index = characters.current()
    vias = characters.vias_of(rig) if vias is None else vias
    if state and not state.has_rest_of(rig):
        state = None
    if state and state.bone_settings is None:
        state.bone_settings = rig_pose.read_bone_settings(rig, state.rest)
    settings = tissue_snapshot.settings_of(tissues) + tissue_snapshot.via_settings_of(vias)
    empties = tissues + vias
    animated = tissue_snapshot.animated(empties)
    is_any_disabled = any(empty.hide_viewport for empty in empties)
    rows = state.tissue_rows if state and state.character_index is index else tissue_snapshot.rows_of(empties)
    transforms = tissue_snapshot.transforms_of(rows)
    if state and state.tissue_settings == settings and np.array_equal(state.tissue_transforms, transforms):
        state.character_index, state.tissue_rows, state.animated = index, rows, animated
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
        character_index=index,
        animated=animated,
        is_any_disabled=is_any_disabled,
        display=tissue_display.TissueDisplay(rig, rest, [tissues[in_rig] for in_rig in solved]),
        pose=np.empty((len(rest.skeleton), 4, 4), np.float32),
        influence=np.array([mixing.influence_of(tissues[in_rig]) for in_rig in solved], np.float32),
        tension=np.empty(len(solved), np.float32),
        posed=np.empty((len(solved), 4, 4), np.float32),
        bone_settings=state.bone_settings if state else rig_pose.read_bone_settings(rig, rest),
    )
    _rigs[rig.session_uid] = state
    return state


def forget_shown():
    """The next frame shows the Empties of all rigs again, whatever they show now."""
    for state in _rigs.values():
        state.display.forget()


def forget_shown_of(rig):
    """The next frame shows the Empties of a rig again, and compares what is now disabled, whose edits are not reported."""
    if rig.session_uid in _rigs:
        _rigs[rig.session_uid].display.forget()
        mark_rig_dirty(rig)


def skin_state(skin, rig: RigState, mesh_to_armature: np.ndarray, edited: EditScope = EditScope.ANYTHING) -> SkinState:
    """The bind of a mesh to its rig's tissues, made again if mesh, tissues, weights or settings changed.

    mesh_to_armature: (4, 4) float32, column-major. edited: as for `rig_state`. Raises SinewError, or ValueError from the
    core, if the mesh can't be bound.
    """
    mesh = skin.data
    state = _skins.get(skin.session_uid)
    if state and EditScope.ANY_DATA not in edited and not skin.animation_data and state.fits(mesh, rig, mesh_to_armature):
        return state
    settings, weight_sources = bind_settings(skin, rig.rest.size), weight_sources_of(skin)
    points = mesh_arrays.read_points(mesh)
    if state and not state.is_of_same_mesh(mesh, points, weight_sources, rig.rest, mesh_to_armature):
        state = None
    topology = mesh_arrays.topology_hash(mesh) if state is None or state.is_dirty else state.topology
    if state and topology != state.topology:
        state = None
    if state and not state.is_dirty:
        weights, painted = state.weights, state.painted
    else:
        # with the transform of the bind, so that rounding does not change the weights of B-Bones
        transform = state.mesh_to_armature if state else mesh_to_armature
        weights = bone_weights.read_weights(skin, rig.rest, Matrix(transform.T.tolist()))
        painted = painted_data.read(skin)
    if state:
        state.is_dirty = False
        if (
            state.musculature is rig.musculature
            and state.settings == settings
            and state.bone_settings is rig.bone_settings
            and state.weights == weights
            and _same_arrays(state.painted, painted)
        ):
            return state
    # if only settings or tissues changed, the cached weights are used: reading them takes as long as binding
    edges = mesh_arrays.read_edges(mesh)
    state = SkinState(
        rest=rig.rest,
        musculature=rig.musculature,
        mesh_uid=mesh.session_uid,
        points=points,
        edge_count=len(edges),
        topology=topology,
        mesh_to_armature=mesh_to_armature,
        settings=settings,
        weight_sources=weight_sources,
        weights=weights,
        bone_settings=rig.bone_settings,
        painted=painted,
        skin=bind(skin, rig, points, edges, mesh_to_armature, weights, painted),
        correction=np.zeros_like(points),
        mesh_correction=np.empty_like(points),
    )
    _skins[skin.session_uid] = state
    return state


def _same_arrays(before: dict[str, np.ndarray], now: dict[str, np.ndarray]) -> bool:
    return before is now or (before.keys() == now.keys() and all(np.array_equal(before[name], now[name]) for name in before))
