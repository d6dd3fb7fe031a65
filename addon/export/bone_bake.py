# SPDX-License-Identifier: GPL-3.0-or-later
"""Muscles baked to bones: an export copy of a character whose skin follows bones that stretch, and nothing of Sinew's."""

import math
from collections.abc import Iterator
from dataclasses import dataclass

import bpy
import numpy as np

from ..bake.scratch.pose_sampler import PoseSampler
from ..errors import SinewError
from ..live import session
from ..live.rig_cache import RigState
from ..live.skin_cache import SkinState
from ..scene import armature_modifier, characters, mesh_arrays, rig_pose, tissue_empty
from . import engine_weights, export_copy, muscle_bones, muscle_keys, refit_keys
from .copy_pose import PosedCopy
from .restore_context import select, show, undisturbed

FITTED = "FITTED"


@dataclass(frozen=True)
class Settings:
    """What is baked. most: bones that weigh a vertex. keyed: keys instead of constraints. weights: "FITTED" or "BIND"."""

    frame_start: int
    frame_end: int
    step: int
    most: int
    keyed: bool
    weights: str


@dataclass
class Difference:
    """Distances from the live skin over frames, mm in the world: of the copy, and of the Armature modifier alone."""

    mean_mm: float = 0.0
    max_mm: float = 0.0
    bare_mean_mm: float = 0.0
    bare_max_mm: float = 0.0


class BoneBake:
    """A bake of a rig's muscles to bones. Run through `steps`; where they are closed before their end, nothing has changed."""

    def __init__(self, context, rig, skins: list, settings: Settings):
        _check(rig, skins, settings)
        self._context, self._settings = context, settings
        self.rig, self._skins = rig.name, [skin.name for skin in skins]
        self._live_before = {skin.name: skin.sinew.skin.live for skin in skins}
        self.frames = list(range(settings.frame_start, settings.frame_end + 1, settings.step))
        self.muscles: list[muscle_bones.MuscleBone] = []
        self.unfit: list[str] = []
        self.difference = Difference()

    def steps(self) -> Iterator[float]:
        """Bakes, yielding the part done, 0..1. Raises SinewError."""
        context, rig = self._context, bpy.data.objects[self.rig]
        with undisturbed(context):
            old = rig.sinew.rig.export_copy
            rig.sinew.rig.export_copy = None
            try:
                yield from self._bake(rig)
            except BaseException:  # also where the person stopped it: a generator that is closed
                export_copy.remove(rig)
                rig.sinew.rig.export_copy = old
                raise
            finally:
                for name, live in self._live_before.items():
                    bpy.data.objects[name].sinew.skin.live = live
            new = rig.sinew.rig.export_copy
            rig.sinew.rig.export_copy = old
            export_copy.remove(rig)
            rig.sinew.rig.export_copy = new
            export_copy.name(new, rig, [bpy.data.objects[name] for name in self._skins])
            show(context.view_layer, new, False)
        yield 1.0

    def _bake(self, rig) -> Iterator[float]:
        scene, layer = self._context.scene, self._context.view_layer
        skins = [bpy.data.objects[name] for name in self._skins]
        for skin in skins:
            skin.sinew.skin.live = True
        scene.frame_set(self.frames[0])
        state = self._state_of(rig, skins)
        tissues = characters.tissues_of(rig)
        solved = [tissues[place] for place in state.solved]
        shapes = [tissue_empty.read(empty, rig) for empty in solved if empty.sinew.tissue.kind == "MUSCLE"]
        if not shapes:
            raise SinewError(f"{rig.name} has no muscle that can be used")
        _collection, rig_copy, skin_copies = export_copy.make(rig, skins, scene)
        layer.update()
        select(layer, [rig_copy], rig_copy)
        self.muscles = muscle_bones.build(rig_copy, shapes, self._settings.keyed)
        copied = rig_pose.read_rest(rig_copy)
        posed = PosedCopy(state, copied, self.muscles, [empty.name for empty in solved])

        poses, tensions, targets = [], [], [[] for _ in skins]
        for done, frame in enumerate(self.frames, 1):
            scene.frame_set(frame)
            state = self._state_of(rig, skins)
            poses.append(posed.pose(state.pose, state.tension))
            tensions.append(state.tension.copy())
            for skin, own in zip(skins, targets, strict=True):
                own.append(_live_points(session.cached_skin(skin), state))
            yield 0.4 * done / len(self.frames)
        poses = np.array(poses)
        self._key(rig_copy, poses, np.array(tensions), posed)

        for place, (skin, copy) in enumerate(zip(skins, skin_copies, strict=True)):
            skin_state = session.cached_skin(skin)
            if self._settings.weights == FITTED:
                own = poses, np.array(targets[place])
                rows = engine_weights.fitted(skin_state, copied, posed.frames, self._settings.most, *own)
            else:
                rows = engine_weights.of_bind(skin_state, copied, posed.frames, self._settings.most)
            engine_weights.write(copy, copied, rows)
            linear = engine_weights.skin_of(skin_state, copied, rows)
            self._compare_bare(skin, skin_state, copied, poses, targets[place])
            yield from self._rebase(rig, rig_copy, skin, copy, posed, linear)
        for done, frame in enumerate(self.frames, 1):
            self._compare(frame, skins, skin_copies)
            yield 0.7 + 0.3 * done / len(self.frames)
        self.difference.mean_mm /= len(self.frames) * len(skins)
        self.difference.bare_mean_mm /= len(self.frames) * len(skins)

    def _state_of(self, rig, skins: list) -> RigState:
        for skin in skins:
            if session.reason(skin) or session.cached_skin(skin) is None:
                raise SinewError(
                    session.reason(skin) or f"{skin.name} is not part of this scene and view layer: make it visible"
                )
        return session.cached_rig(rig)

    def _key(self, rig_copy, poses: np.ndarray, tensions: np.ndarray, posed: PosedCopy):
        """Keys what constraints can't say: muscles that they can't stretch, and tension."""
        keyed = [muscle for muscle in self.muscles if muscle.is_keyed]
        tense = [
            (muscle, tensions[:, tissue].astype(float))
            for muscle, tissue in zip(self.muscles, posed.frames.tissues, strict=True)
            if not muscle.is_keyed and tensions[:, tissue].any()
        ]
        if keyed or any(np.ptp(tension) for _, tension in tense):
            curves = muscle_keys.own_curves(rig_copy)
            muscle_keys.key_bones(curves, rig_copy, keyed, self.frames, poses)
        for muscle, tension in tense:
            if np.ptp(tension):
                muscle_keys.key_tension(curves, muscle, self.frames, tension)
            else:
                muscle_keys.hold_tension(rig_copy, muscle, float(tension[0]))

    def _rebase(self, rig, rig_copy, skin, copy, posed: PosedCopy, linear) -> Iterator[float]:
        """Makes the baked keys of a copy fit its weights."""
        keys = copy.data.shape_keys
        acting = [
            baked
            for baked in skin.sinew.skin.baked_keys
            if not baked.muted_by_sinew and keys and baked.name in keys.key_blocks
        ]
        acting.sort(key=lambda baked: len(baked.joints.split("\n")))
        found = {baked.name: refit_keys.pose_of(baked) for baked in acting}
        if not acting:
            return
        scene = self._context.scene
        fit = refit_keys.KeyRefit(copy, linear, session.cached_skin(skin).points, list(found))
        for number, (name, pose) in enumerate(found.items()):
            if pose is not None and pose.frame is not None:
                whole = math.floor(pose.frame)
                scene.frame_set(whole, subframe=pose.frame - whole)
                state = self._state_of(rig, [skin])
                fit.fit(name, posed.pose(state.pose, state.tension), _live_points(session.cached_skin(skin), state))
            yield 0.4 + 0.15 * number / len(found)
        turned = {name: pose.turns for name, pose in found.items() if pose is not None and pose.frame is None}
        if turned:
            yield from self._rebase_turned(rig, rig_copy, skin, posed, fit, turned)
        self.unfit += fit.write()

    def _rebase_turned(
        self, rig, rig_copy, skin, posed: PosedCopy, fit: refit_keys.KeyRefit, turned: dict
    ) -> Iterator[float]:
        ours = frozenset(name for muscle in self.muscles for name in (muscle.bone, muscle.insertion) if name)
        no_tension = np.zeros_like(session.cached_rig(rig).tension)
        sampler = PoseSampler(rig, [skin])
        try:
            sampler.pose_for(
                self._context.scene, rig, list({motion.bone for turns in turned.values() for motion, _ in turns})
            )
            with refit_keys.resting(rig_copy, ours) as turn:
                for number, (name, turns) in enumerate(turned.items()):
                    turn(turns)
                    (target,) = sampler.deformed(turns)
                    fit.fit(name, posed.pose(sampler.pose, no_tension), target)
                    yield 0.55 + 0.15 * number / len(turned)
        finally:
            sampler.remove()

    def _compare_bare(self, skin, state: SkinState, copied: rig_pose.RigRest, poses: np.ndarray, targets: list):
        """Adds the distances of the skin that its own bones alone carry, in all frames."""
        bare, nothing, out = engine_weights.bare(state, copied), np.zeros_like(state.points), np.empty_like(state.points)
        to_world_mm = 1000.0 * np.array(skin.matrix_world.to_3x3()).T
        for pose, target in zip(poses, targets, strict=True):
            bare.deform(pose, nothing, out)
            apart_mm = np.linalg.norm((out - target) @ to_world_mm, axis=1)
            self.difference.bare_mean_mm += float(apart_mm.mean())
            self.difference.bare_max_mm = max(self.difference.bare_max_mm, float(apart_mm.max()))

    def _compare(self, frame: int, skins: list, skin_copies: list):
        """Adds the distances of a frame, as Blender evaluates all of it."""
        self._context.scene.frame_set(frame)
        depsgraph = self._context.evaluated_depsgraph_get()
        for skin, copy in zip(skins, skin_copies, strict=True):
            live, engine = (_world_points(found.evaluated_get(depsgraph)) for found in (skin, copy))
            if live.shape != engine.shape:
                raise SinewError(
                    f"{skin.name}: its modifiers make {len(engine)} vertices of the copy, {len(live)} of the skin"
                )
            apart_mm = 1000.0 * np.linalg.norm(live - engine, axis=1)
            self.difference.mean_mm += float(apart_mm.mean())
            self.difference.max_mm = max(self.difference.max_mm, float(apart_mm.max(initial=0.0)))


def _check(rig, skins: list, settings: Settings):
    if settings.frame_end < settings.frame_start:
        raise SinewError(f"The last frame ({settings.frame_end}) lies before the first ({settings.frame_start})")
    if rig.data.pose_position == "REST":
        raise SinewError(
            f"{rig.name} shows its rest pose, in which no muscle moves: switch to Pose Position (Edit Rest Pose)"
        )
    if rig.library or any(skin.library for skin in skins):
        raise SinewError(f"{rig.name} is linked from another file: make it local, or bake it there")
    for skin in skins:
        if not armature_modifier.is_bound(skin):
            raise SinewError(f"{skin.name} is not bound: bind it first (Bind Skin)")
        if skin.data.is_editmode:
            raise SinewError(f"{skin.name} is in Edit Mode: leave it (Tab) and bake again")
        if armature_modifier.rig_of(skin) != rig:
            raise SinewError(f"{skin.name} follows another armature than {rig.name}: select meshes of one character")
        modifiers = armature_modifier.armature_modifiers(skin)
        if not modifiers:
            raise SinewError(
                f"{skin.name} has no Armature modifier: bones could not move it. Parent it to {rig.name} (Ctrl+P)"
            )
        if modifiers[0].vertex_group:
            raise SinewError(
                f"{skin.name}: Armature modifier '{modifiers[0].name}' has a vertex group, which no engine knows: clear it"
            )


def _live_points(state: SkinState, rig: RigState) -> np.ndarray:
    """(vertices, 3) float32: the live skin in the pose that the rig's state has, mesh space, without the mesh's other keys."""
    out = np.empty_like(state.points)
    state.skin.deform(rig.pose, rig.tension, out)
    return out


def _world_points(evaluated) -> np.ndarray:
    points = mesh_arrays.read_evaluated_points(evaluated.data).astype(np.float64)
    world = np.array(evaluated.matrix_world)
    return points @ world[:3, :3].T + world[:3, 3]
