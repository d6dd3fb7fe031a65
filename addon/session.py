# SPDX-License-Identifier: GPL-3.0-or-later
"""The live Rust objects: made from what stands in the file, dropped on load and undo, made anew when it changed.

Nothing here is a source of truth. Whether a kept object still fits is asked of the file at every frame (positions,
transforms, settings), except for what Blender gives no cheap look at: bone weights and what is painted are read again
after Blender reported a change of that mesh (`suspect_skin`), settings of bones after one was changed
(`forget_bone_settings`). Where Blender says that nothing was edited since the last frame (`handlers`), only what can
change without an edit is asked for: what is animated, and the transforms of Empties.
"""

from dataclasses import dataclass

import _sinew
import numpy as np
from mathutils import Matrix

from . import mesh_io, painted_io, posed_empties, rig_io, roster, tissue_fingerprint, tissue_io
from .edited import Edited
from .errors import SinewError

REACH_OF_RIG_SIZE = 0.03 / 1.73  # 3 cm on a man of 1.73 m (ALGORITHM 3)
SOFTNESS_OF_RIG_SIZE = 0.004 / 1.73
SAME_PLACE_OF_SIZE = 1e-5


@dataclass
class RigState:
    """A rig's rest pose and musculature, what they were made from, and the arrays of the current frame."""

    rest: rig_io.RigRest
    tissue_settings: list[tuple]
    tissue_rows: np.ndarray
    tissue_transforms: np.ndarray
    musculature: _sinew.Musculature | None
    solved: list[int]  # places, among the rig's tissues, of those that the musculature has
    problems: dict[str, str]
    roster: roster.Roster | None  # of the last look at all of the file; None: to be looked at again
    animated: list[int]  # places, among the rig's tissues and via points, of those that have keys or drivers
    shown: posed_empties.PosedEmpties
    pose: np.ndarray
    tension: np.ndarray
    posed: np.ndarray
    bone_settings: dict[str, np.ndarray] | None  # see rig_io.read_bone_settings; None: to be read again


@dataclass
class SkinState:
    """A bound mesh: what it was bound from, the bind, and the arrays of its current frame."""

    rest: rig_io.RigRest
    musculature: _sinew.Musculature
    mesh_uid: int
    points: np.ndarray
    edge_count: int
    mesh_to_armature: np.ndarray
    settings: tuple
    weighing: tuple  # see _weighing
    weights: mesh_io.BoneWeights
    bone_settings: dict[str, np.ndarray]
    painted: dict[str, np.ndarray]
    skin: _sinew.Skin
    correction: np.ndarray
    present: np.ndarray
    written: np.ndarray | None = None  # some of the correction that was written to the mesh last
    report: _sinew.FrameReport | None = None
    suspect: bool = False


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


def suspect_rigs():
    """A setting was changed: all that tissues depend on is compared at the next frame."""
    for state in _rigs.values():
        state.roster = None


def suspect_skin(skin):
    """Blender reported a change of the mesh: weights and what is painted are compared at the next frame."""
    if skin.session_uid in _skins:
        _skins[skin.session_uid].suspect = True


def keep_skin(skin, state: SkinState):
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


def rig_state(rig, tissues: list, vias: list | None = None, edited: Edited = Edited.ANYTHING) -> RigState:
    """The state of a rig with these tissues, made anew where the file changed. Raises ValueError of the core.

    vias: the Empties of its muscles' via points, in the order of their names; None looks for them. edited: since the last
    frame; not all of the file is then looked at.
    """
    state = _rigs.get(rig.session_uid)
    if state and Edited.OTHERS not in edited and state.roster is roster.kept() and _still_fits(state, rig, tissues, edited):
        if state.bone_settings is None:
            state.bone_settings = rig_io.read_bone_settings(rig, state.rest)
        return state
    known = roster.now()
    vias = roster.vias_of(rig) if vias is None else vias
    if state and not _same_rest(rig, state.rest):
        state = None
    if state and state.bone_settings is None:
        state.bone_settings = rig_io.read_bone_settings(rig, state.rest)
    settings = tissue_fingerprint.settings_of(tissues) + tissue_fingerprint.via_settings_of(vias)
    animated = tissue_fingerprint.animated(tissues + vias)
    rows = state.tissue_rows if state and state.roster is known else tissue_fingerprint.rows_of(tissues + vias)
    transforms = tissue_fingerprint.transforms_of(rows)
    if state and state.tissue_settings == settings and np.array_equal(state.tissue_transforms, transforms):
        state.roster, state.tissue_rows, state.animated = known, rows, animated
        return state
    rest = state.rest if state else rig_io.read_rest(rig)
    musculature, solved, problems = _read_musculature(rig, rest, tissues, vias)
    state = RigState(
        rest=rest,
        tissue_settings=settings,
        tissue_rows=rows,
        tissue_transforms=transforms,
        musculature=musculature,
        solved=solved,
        problems=problems,
        roster=known,
        animated=animated,
        shown=posed_empties.PosedEmpties(rig, rest, [tissues[place] for place in solved]),
        pose=np.empty((len(rest.skeleton), 4, 4), np.float32),
        tension=np.empty(len(solved), np.float32),
        posed=np.empty((len(solved), 4, 4), np.float32),
        bone_settings=state.bone_settings if state else rig_io.read_bone_settings(rig, rest),
    )
    _rigs[rig.session_uid] = state
    return state


def _still_fits(state: RigState, rig, tissues: list, edited: Edited) -> bool:
    """Whether a rig's state fits, where nothing else than its armature and transforms was edited."""
    if Edited.ARMATURES in edited and not _same_rest(rig, state.rest):
        return False
    if state.animated:
        if state.animated[-1] >= len(tissues):  # a via point
            return False
        settings = tissue_fingerprint.settings_of([tissues[place] for place in state.animated])
        if settings != [state.tissue_settings[place] for place in state.animated]:
            return False
    if not state.animated and Edited.TRANSFORMS not in edited:
        return True
    return np.array_equal(tissue_fingerprint.transforms_of(state.tissue_rows), state.tissue_transforms)


def forget_shown():
    """Nothing of what the Empties show can be relied on any more: the next frame shows all of them again."""
    for state in _rigs.values():
        state.shown.forget()


def _same_rest(rig, rest: rig_io.RigRest) -> bool:
    return rig_io.signature(rig) == rest.signature and np.array_equal(rig_io.rest_matrices(rig), rest.bone_rest)


def _read_musculature(rig, rest: rig_io.RigRest, tissues: list, vias: list):
    """The musculature of all tissues that can be solved, their places, and for each other one what is wrong with it."""
    shapes, problems = {}, {}
    vias_by_muscle = tissue_io.vias_by_muscle(vias)
    for place, empty in enumerate(tissues):
        try:
            shapes[place] = tissue_io.read(empty, rig, vias_by_muscle.get(empty.name_full, []))
        except SinewError as error:
            problems[empty.name] = str(error)
    spheres = {shape.name for shape in shapes.values() if shape.kind == "SPHERE"}
    found, solved = [], []
    for place, shape in shapes.items():
        try:
            found.append(_tissue(shape, rest, spheres))
            solved.append(place)
        except (SinewError, _sinew.SinewError) as error:
            problems[shape.name] = str(error)
    return (_sinew.Musculature(rest.skeleton, found) if found else None), solved, problems


def _tissue(shape: tissue_io.TissueShape, rest: rig_io.RigRest, spheres: set[str]) -> _sinew.Tissue:
    unsolved = [name for name in shape.wraps if name not in spheres]
    if unsolved:
        raise SinewError(f"{shape.name}: goes round {unsolved[0]}, which has a problem of its own; mend that, or wrap another")
    return _sinew.Tissue(
        shape.name,
        shape.kind,
        rest.frame_of_bone[shape.origin_bone],
        rest.frame_of_bone[shape.insertion_bone],
        tuple(shape.centre),
        tuple(shape.rotation),
        tuple(shape.semi_axes),
        shape.origin_tendon,
        shape.insertion_tendon,
        shape.volume_keeping,
        via_points=[(rest.frame_of_bone[bone], tuple(point)) for bone, point in shape.via_points],
        wraps=shape.wraps,
    )


def skin_state(skin, rig: RigState, mesh_to_armature: np.ndarray, edited: Edited = Edited.ANYTHING) -> SkinState:
    """The bind of a mesh to its rig's tissues, made anew where mesh, tissues, weights or settings changed.

    mesh_to_armature: (4, 4) float32, column-major. edited: as for `rig_state`. Raises SinewError or ValueError (of the
    core) where it can't be bound.
    """
    mesh = skin.data
    state = _skins.get(skin.session_uid)
    if state and Edited.OTHERS not in edited and not skin.animation_data and _fits(state, mesh, rig, mesh_to_armature):
        return state
    settings, weighing = _bind_settings(skin, rig.rest.size), _weighing(skin)
    points = mesh_io.read_points(mesh)
    if state and not _is_of_same_mesh(state, mesh, points, weighing, rig.rest, mesh_to_armature):
        state = None
    if state and not state.suspect:
        weights, painted = state.weights, state.painted
    else:
        place = state.mesh_to_armature if state else mesh_to_armature
        weights = mesh_io.read_weights(skin, rig.rest, Matrix(place.T.tolist()))
        painted = painted_io.read(skin)
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
    edges = mesh_io.read_edges(mesh)
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
        skin=_bind(skin, rig, points, edges, mesh_to_armature, weights, painted),
        correction=np.zeros_like(points),
        present=np.empty_like(points),
    )
    _skins[skin.session_uid] = state
    return state


def _fits(state: SkinState, mesh, rig: RigState, mesh_to_armature) -> bool:
    """Whether a bind fits a mesh, which was not edited since, in its place and on its rig of this frame."""
    return (
        not state.suspect
        and state.mesh_uid == mesh.session_uid
        and (len(state.points), state.edge_count) == (len(mesh.vertices), len(mesh.edges))
        and state.rest is rig.rest
        and state.musculature is rig.musculature
        and state.bone_settings is rig.bone_settings
        and _same_place(state.mesh_to_armature, mesh_to_armature, rig.rest.size)
    )


def _is_of_same_mesh(state: SkinState, mesh, points, weighing: tuple, rest: rig_io.RigRest, mesh_to_armature) -> bool:
    """Whether nothing changed of what the weights were read from, but for the weights themselves."""
    return (
        state.mesh_uid == mesh.session_uid
        and state.rest is rest
        and state.weighing == weighing
        and state.edge_count == len(mesh.edges)
        and np.array_equal(state.points, points)
        and _same_place(state.mesh_to_armature, mesh_to_armature, rest.size)
    )


def _bind(skin, rig: RigState, points, edges, mesh_to_armature, weights, painted) -> _sinew.Skin:
    if rig.musculature is None:
        if rig.problems:
            raise SinewError(f"{skin.name}: none of its armature's muscles can be used. {'; '.join(rig.problems.values())}")
        raise SinewError(f"{skin.name}: its armature has no muscles; add some (Add Preset, Add Tissue)")
    own = skin.sinew
    reach, softness = _lengths(own, rig.rest.size)
    return _sinew.Skin(
        rig.musculature,
        points,
        edges,
        mesh_to_armature,
        weights.offsets,
        weights.frames,
        weights.weights,
        skinning=mesh_io.skinning_of(skin),
        anchoring=own.anchoring,
        # nothing else could carry a mesh without weights
        carry=own.carry if len(weights.frames) else "FULL",
        scale_fat=own.scale_fat,
        reach=reach,
        softness=softness,
        gain=own.gain,
        muscle_influence=_regional("muscle_influence", 1.0, rig, painted),
        elasticity=_elasticity(skin, rig, edges, painted) if own.elastic else None,
    )


def _regional(name: str, of_mesh: float, rig: RigState, painted) -> _sinew.Regional:
    return _sinew.Regional(of_mesh, rig.bone_settings.get(name), painted.get(name))


def _elasticity(skin, rig: RigState, edges, painted) -> _sinew.Elasticity:
    mesh, own = skin.data, skin.sinew
    return _sinew.Elasticity(
        mesh_io.read_struts(mesh, edges),
        mesh_io.read_triangles(mesh),
        rig.rest.segments,
        rig.rest.lengths,
        own.iterations,
        energy=own.energy,
        anchor_stiffness=_regional("anchor_stiffness", own.anchor_stiffness, rig, painted),
        edge_stiffness=_regional("edge_stiffness", own.edge_stiffness, rig, painted),
        rest_distance=_regional("rest_distance", own.rest_distance, rig, painted),
        relaxation=_regional("relaxation", 1.0, rig, painted),
        fat_sliding=_regional("fat_sliding", own.fat_sliding, rig, painted),
        volume=rig.bone_settings.get("keep_volume"),
        crease=rig.bone_settings.get("crease"),
        contact=rig.bone_settings.get("contact"),
        collides=own.collides,
        contacts=own.contacts,
    )


def _bind_settings(skin, rig_size: float) -> tuple:
    own = skin.sinew
    return (
        own.anchoring, own.carry, own.scale_fat, own.gain, own.elastic, own.iterations, own.energy, own.anchor_stiffness,
        own.edge_stiffness, own.rest_distance, own.fat_sliding, own.collides, own.contacts, _lengths(own, rig_size)
    )  # fmt: skip


def _weighing(skin) -> tuple:
    """What decides which of a mesh's vertex groups weigh, and how."""
    return mesh_io.modifier_state(skin), skin.vertex_groups.keys()


def _lengths(own, rig_size: float) -> tuple[float, float]:
    """Reach and softness, in armature space; both follow the size of the rig unless the person chose a reach."""
    return own.reach or REACH_OF_RIG_SIZE * rig_size, SOFTNESS_OF_RIG_SIZE * rig_size


def _same_arrays(kept: dict[str, np.ndarray], now: dict[str, np.ndarray]) -> bool:
    return kept is now or kept.keys() == now.keys() and all(np.array_equal(kept[name], now[name]) for name in kept)


def _same_place(kept: np.ndarray, now: np.ndarray, size: float) -> bool:
    if np.array_equal(kept, now):
        return True
    # transforms of a character far from the world's origin tremble by rounding; that is no new place
    tolerance = SAME_PLACE_OF_SIZE * np.array([1.0, 1.0, 1.0, max(size, 1e-3)])[:, None]
    return bool((np.abs(kept - now) <= tolerance * max(1.0, float(np.abs(kept[:3]).max()))).all())
