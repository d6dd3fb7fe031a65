# SPDX-License-Identifier: GPL-3.0-or-later
"""The cache of this session: the core's musculatures and binds, made from the file and dropped on load.

The cache is never a source of truth. Each frame compares positions, transforms and settings with the file, and what changed
is made again. Some data is too slow to compare in each frame. Bone weights and painted factors are read again after Blender
reports a change of the mesh (`mark_weights_dirty`), and settings of bones after one of them changed
(`forget_bone_settings`). If Blender reports no edit since the last frame (`handlers`), a frame compares only what can
change without an edit: animated values, and the transforms of Empties.
"""

import bpy
import numpy as np
from mathutils import Matrix

from ..errors import SinewError
from ..scene import (
    animated_value,
    bone_weights,
    characters,
    mesh_arrays,
    mixing,
    painted_data,
    rest_body,
    rig_pose,
    tissue_display,
)
from ..scene.level_of_detail import Detail
from . import tissue_snapshot
from .edit_flags import EditScope
from .rig_cache import RigState, has_keyed_bones, read_musculature, unevaluated
from .skin_cache import SkinData, SkinState, bind, bind_settings, weight_sources_of

_rigs: dict[int, RigState] = {}
_skins: dict[int, SkinState] = {}
# binds of the same meshes with other details, such as that of renders: a switch of the detail binds nothing
_spares: dict[int, list[SkinState]] = {}
_MOST_SPARES = 2
_reasons: dict[int, str] = {}


def forget():
    """Drops everything, on load."""
    _rigs.clear()
    _skins.clear()
    _spares.clear()
    _reasons.clear()


def distrust():
    """After undo or redo, the next frame compares everything with the file. Binds that still fit are kept."""
    present = {found.session_uid: found for found in bpy.data.objects}
    for uid, state in list(_rigs.items()):
        if _has_rest(present.get(uid), state):
            state.character_index, state.are_bones_dirty = None, True
            state.display.forget()
        else:
            del _rigs[uid]
    for uid, bound in list(_skins.items()):
        if uid in present:
            bound.is_dirty = True
        else:
            del _skins[uid]
    _spares.clear()
    _reasons.clear()


def _has_rest(rig, state: RigState) -> bool:
    """Whether an object is a rig with the rest pose of a state, also in what only Edit Mode can change."""
    if rig is None or rig.type != "ARMATURE" or rig.mode == "EDIT":
        return False
    try:
        return rig_pose.read_rest(rig).is_same(state.rest)
    except (SinewError, ValueError):
        return False  # the next frame says why


def forget_skin(skin):
    """Drops the binds of a mesh."""
    _skins.pop(skin.session_uid, None)
    _spares.pop(skin.session_uid, None)
    _reasons.pop(skin.session_uid, None)


def forget_rig(rig):
    """Drops the rest pose and musculature of a rig, while it is in Edit Mode."""
    _rigs.pop(rig.session_uid, None)


def forget_bone_settings(rig):
    """A setting of a rig's bones changed: the next frame reads them again."""
    if rig.session_uid in _rigs:
        _rigs[rig.session_uid].are_bones_dirty = True


def mark_rig_dirty(rig):
    """A setting of a rig, its tissues or its skins changed: the next frame compares everything that they depend on."""
    if rig.session_uid in _rigs:
        _rigs[rig.session_uid].character_index = None


def mark_weights_dirty(skin):
    """Blender reported a change of the mesh: the next frame reads its weights and painted factors again."""
    if skin.session_uid in _skins:
        _skins[skin.session_uid].is_dirty = True
        _spares.pop(skin.session_uid, None)


def pin_bind(skin, state: SkinState):
    """Makes the next frame start with a bind of an earlier frame.

    A bind is kept while the mesh moves only by rounding, so binds of different frames differ by rounding. With one pinned
    bind, all chunks of a farm bake start from the same.
    """
    _skins[skin.session_uid] = state
    _spares.pop(skin.session_uid, None)


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


def rig_state(
    rig,
    tissues: list,
    depsgraph,
    vias: list | None = None,
    edited: EditScope = EditScope.ANYTHING,
    read: tissue_snapshot.ObjectTransforms | None = None,
) -> RigState:
    """The state of a rig with these tissues, updated if the file changed. Raises ValueError from the core.

    depsgraph: the evaluation that keyed and driven values are read from. vias: the Empties of its muscles' via points,
    sorted by name. None searches for them. edited: what was edited since the last frame; other data is not compared.
    read: the transforms of this frame, if it has other rigs as well.
    """
    state, read = _rigs.get(rig.session_uid), read or tissue_snapshot.ObjectTransforms()
    vias = characters.vias_of(rig) if vias is None else vias
    if (
        state
        and EditScope.ANY_DATA not in edited
        and state.character_index is characters.cached()
        and state.still_fits(rig, tissues, vias, edited, depsgraph, read)
    ):
        state.update_bone_settings(rig, depsgraph)
        return state
    index = characters.current()
    if state and not state.has_rest_of(rig):
        state = None
    sources, keyed_bones = animated_value.sources_of(rig), has_keyed_bones(rig)
    if state:
        state.animation_sources, state.has_keyed_bones = sources, keyed_bones
        state.update_bone_settings(rig, depsgraph)
    settings = tissue_snapshot.settings_of(tissues, depsgraph) + tissue_snapshot.via_settings_of(vias)
    empties = tissues + vias
    animated, animated_shapes = tissue_snapshot.animated(empties), tissue_snapshot.with_animated_shape(empties)
    is_any_disabled = any(empty.hide_viewport for empty in empties)
    rows = state.tissue_rows if state and state.character_index is index else tissue_snapshot.rows_of(empties)
    transforms = tissue_snapshot.transforms_of(empties, rows, depsgraph, read)
    if state and state.problems and state.rig_name != rig.name:
        state = None  # the problems name the rig
    if state and state.tissue_settings == settings and np.array_equal(state.tissue_transforms, transforms):
        state.character_index, state.tissue_rows, state.animated = index, rows, animated
        state.animated_shapes, state.is_any_disabled = animated_shapes, is_any_disabled
        if depsgraph.mode == "VIEWPORT":
            state.problems = state.unusable | unevaluated(empties, animated, depsgraph)
        return state
    rest = state.rest if state else rig_pose.read_rest(rig)
    musculature, solved, unusable = read_musculature(rig, rest, tissues, vias, depsgraph)
    state = RigState(
        rig_name=rig.name,
        rest=rest,
        tissue_settings=settings,
        tissue_rows=rows,
        tissue_transforms=transforms,
        musculature=musculature,
        solved=solved,
        unusable=unusable,
        problems=unusable | unevaluated(empties, animated, depsgraph),
        character_index=index,
        animated=animated,
        animated_shapes=animated_shapes,
        animation_sources=sources,
        has_keyed_bones=keyed_bones,
        is_any_disabled=is_any_disabled,
        display=tissue_display.TissueDisplay(rig, rest, [tissues[in_rig] for in_rig in solved]),
        pose=np.empty((len(rest.skeleton), 4, 4), np.float32),
        influence=np.array([mixing.influence_of(tissues[in_rig]) for in_rig in solved], np.float32),
        tension=np.empty(len(solved), np.float32),
        posed=np.empty((len(solved), 4, 4), np.float32),
        bone_settings=state.bone_settings if state else None,
    )
    state.update_bone_settings(rig, depsgraph)
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


def skin_state(
    skin,
    rig: RigState,
    mesh_to_armature: np.ndarray,
    depsgraph,
    detail: Detail,
    edited: EditScope = EditScope.ANYTHING,
    body: SkinState | None = None,
) -> SkinState:
    """The bind of a mesh to its rig's tissues, made again if mesh, tissues, weights or settings changed.

    mesh_to_armature: (4, 4) float32, column-major. depsgraph, edited: as for `rig_state`. detail: how much of the skin is
    computed; binds of other details are kept for evaluations that need them. body: the bind of the mesh that it
    is worn over (`garments.skin_state` finds it). Raises SinewError, or ValueError from the core, if the mesh can't be
    bound.
    """
    mesh, values = skin.data, animated_value.values_of(skin, depsgraph)
    state, body_skin = _skins.get(skin.session_uid), body.skin if body else None
    if EditScope.ANY_DATA not in edited:
        for known in (state, *_spares.get(skin.session_uid, ())):
            if (
                known
                and known.body is body_skin
                and known.fits(skin, rig, mesh_to_armature, detail)
                and (values is skin or known.has_values_of(skin, values, detail, rig.rest.size))
            ):
                return _make_current(skin, known)
    if state and state.body is not body_skin:
        state = None
    settings, weight_sources = bind_settings(values, detail, rig.rest.size), weight_sources_of(skin, values)
    points = rest_body.read_points(skin)
    if state and not state.is_of_same_mesh(mesh, points, weight_sources, rig.rest, mesh_to_armature):
        state = None
    topology = mesh_arrays.topology_hash(mesh) if state is None or state.is_dirty else state.topology
    if state and topology != state.topology:
        state = None
    if state and not state.is_dirty:
        weights, painted, shown = state.weights, state.painted, state.shown
    else:
        # with the transform of the bind, so that rounding does not change the weights of B-Bones
        transform = state.mesh_to_armature if state else mesh_to_armature
        weights = bone_weights.read_weights(skin, values, rig.rest, Matrix(transform.T.tolist()), points)
        painted = painted_data.read(skin)
        shown = rest_body.shown_vertices(skin)
    if state:
        state.is_dirty = False
        # the spares are of the same mesh, because a change of it drops them
        for known in (state, *_spares.get(skin.session_uid, ())):
            if known.has_inputs(rig, settings, weights, painted, shown, body_skin):
                known.detail = detail
                return _make_current(skin, known)
    else:
        _spares.pop(skin.session_uid, None)
    # if only settings or tissues changed, the cached weights are used: reading them takes as long as binding
    edges = mesh_arrays.read_edges(mesh)
    data = SkinData(points, rest_body.shown_only(edges, shown), mesh_to_armature, weights, painted, shown, body)
    bound = SkinState(
        rest=rig.rest,
        musculature=rig.musculature,
        mesh_uid=mesh.session_uid,
        points=points,
        edge_count=len(edges),
        topology=topology,
        mesh_to_armature=mesh_to_armature,
        settings=settings,
        detail=detail,
        key_values=rest_body.key_values(skin),
        weight_sources=weight_sources,
        weights=weights,
        bone_settings=rig.bone_settings,
        painted=painted,
        shown=shown,
        body=body_skin,
        skin=bind(skin, values, detail, rig, data),
        correction=np.zeros_like(points),
        mesh_correction=np.empty_like(points),
    )
    if state:
        # only another detail is likely to be needed again
        is_kept = state.detail != detail and state.musculature is rig.musculature
        spares = [*([state] if is_kept else ()), *_spares.get(skin.session_uid, ())]
        _spares[skin.session_uid] = [spare for spare in spares if spare.musculature is rig.musculature][:_MOST_SPARES]
    _skins[skin.session_uid] = bound
    return bound


def _make_current(skin, state: SkinState) -> SkinState:
    """Makes a bind that is kept that of the current frame."""
    current = _skins.get(skin.session_uid)
    if current is not state:
        spares = _spares[skin.session_uid]
        spares.remove(state)
        if current:
            spares.insert(0, current)
        _skins[skin.session_uid] = state
    return state
