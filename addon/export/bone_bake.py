# SPDX-License-Identifier: GPL-3.0-or-later
"""Bakes muscles to bones: makes an export copy of a character whose skin follows bones that stretch, without Sinew."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import bpy
import numpy as np

from ..bake import requirements
from ..bake.scratch.pose_sampler import PoseSampler
from ..errors import SinewError
from ..live import session
from ..live.rig_cache import RigState
from ..live.skin_cache import SkinState
from ..scene import armature_modifier, characters, live_switch, lookup, mesh_arrays, rig_pose, tissue_empty
from ..scene.current_frame import time_per_frame
from . import applied_scale, engine_weights, export_copy, muscle_bones, muscle_keys, refit_keys, refit_own_keys, scales
from .copy_pose import CopyPose
from .restore_context import restored_context, select, show

FITTED = "FITTED"


@dataclass(frozen=True)
class Settings:
    """What is baked.

    most: the largest number of bones with a weight at a vertex. keyed: all muscle bones get keyframes and no
    constraints. weights: "FITTED" to the frames, or "BIND", the weights of the bind.
    """

    frame_start: int
    frame_end: int
    step: int
    most: int
    keyed: bool
    weights: str


@dataclass
class Difference:
    """Distances from the live skin in all frames, mm in the world: of the copy, and of the Armature modifier alone."""

    mean_mm: float = 0.0
    max_mm: float = 0.0
    bare_mean_mm: float = 0.0
    bare_max_mm: float = 0.0


class BoneBake:
    """A bake of a rig's muscles to bones. If the generator of `steps` is closed before its end, nothing has changed."""

    def __init__(self, context, rig, skins: list, settings: Settings):
        _check(rig, skins, settings)
        self._context, self._settings = context, settings
        self.rig, self._skins = rig.name, [skin.name for skin in skins]
        self._live_before = live_switch.switches_of(skins)
        self._made = ""  # the collection of the unfinished copy
        self.frames = list(range(settings.frame_start, settings.frame_end + 1, settings.step))
        self.muscles: list[muscle_bones.MuscleBone] = []
        self.unfit: list[str] = []
        self.difference = Difference()

    def steps(self) -> Iterator[float]:
        """Bakes and yields the fraction done, 0..1. Raises SinewError."""
        context, rig = self._context, bpy.data.objects[self.rig]
        uid = rig.session_uid
        with restored_context(context) as go_to:
            old = rig.sinew.rig.export_copy
            rig.sinew.rig.export_copy = None
            try:
                yield from self._bake(rig, go_to)
            except BaseException:  # includes the closing of this generator, when the user cancels
                unfinished = bpy.data.collections.get(self._made)
                if unfinished:
                    export_copy.remove_collection(unfinished)
                rig = lookup.by_uid(uid)  # it may have been deleted
                if rig:
                    rig.sinew.rig.export_copy = old
                raise
            finally:
                live_switch.restore_switches(self._live_before)
            lookup.objects_named([self.rig, *self._skins], "bake again")
            new = rig.sinew.rig.export_copy
            rig.sinew.rig.export_copy = old
            export_copy.remove(rig)
            rig.sinew.rig.export_copy = new
            export_copy.name(new, rig, [bpy.data.objects[name] for name in self._skins])
            show(context.view_layer, new, False)
        yield 1.0

    def _bake(self, rig, go_to: Callable[[float], None]) -> Iterator[float]:
        scene, layer = self._context.scene, self._context.view_layer
        skins = [bpy.data.objects[name] for name in self._skins]
        for skin in skins:
            skin.sinew.skin.live = True
        go_to(self.frames[0])
        state = self._state_of(rig, skins)
        tissues = characters.tissues_of(rig)
        solved = [tissues[index] for index in state.solved]
        shapes = [tissue_empty.read(empty, rig) for empty in solved if empty.sinew.tissue.kind == "MUSCLE"]
        if not shapes:
            raise SinewError(f"{rig.name} has no muscle that can be used")
        collection, rig_copy, skin_copies = export_copy.make(rig, skins, scene)
        self._made = collection.name
        layer.update()
        select(layer, [rig_copy], rig_copy)
        # Blender evaluates constraints in the world, where an uneven scale shears bones
        is_even = scales.is_even(rig.matrix_world)
        self.muscles = muscle_bones.build(rig_copy, shapes, self._settings.keyed or not is_even)
        copied = rig_pose.read_rest(rig_copy)
        copy_pose = CopyPose(state, copied, self.muscles, [empty.name for empty in solved])

        poses, tensions, worlds, targets = [], [], [], [[] for _ in skins]
        own_keys = [refit_own_keys.own_keys(skin) for skin in skins]
        own_values: list[list] = [[] for _ in skins]
        for done, frame in enumerate(self.frames, 1):
            go_to(frame)
            state = self._state_of(rig, skins)
            poses.append(copy_pose.matrices(state.pose, state.tension))
            tensions.append(state.tension.copy())
            worlds.append(np.array(rig.matrix_world))
            for skin, of_skin in zip(skins, targets, strict=True):
                of_skin.append(_live_points(session.cached_skin(skin), state))
            for skin, names, of_skin in zip(skins, own_keys, own_values, strict=True):
                of_skin.append(refit_own_keys.values_of(skin, names))
            yield 0.4 * done / len(self.frames)
        poses = np.array(poses)
        self._key(rig_copy, poses, np.array(tensions), copy_pose)

        for skin, copy, of_skin, names, values in zip(skins, skin_copies, targets, own_keys, own_values, strict=True):
            skin_state = session.cached_skin(skin)
            muscles, most = copy_pose.indices, self._settings.most
            if self._settings.weights == FITTED:
                rows = engine_weights.fitted(skin_state, copied, muscles, most, poses, np.array(of_skin))
            else:
                rows = engine_weights.of_bind(skin_state, copied, muscles, most)
            engine_weights.write(copy, copied, rows)
            linear = engine_weights.skin_of(skin_state, copied, rows)
            bare = engine_weights.without_muscles(skin_state, copied)
            self._compare_bare(skin, bare, poses, of_skin)
            refit_own_keys.refit(copy, bare, linear, poses, names, np.array(values).reshape(len(poses), -1))
            yield from self._refit(rig, rig_copy, skin, copy, copy_pose, linear, go_to)
        if not is_even or rig.parent:
            relations = [rig.matrix_world.inverted_safe() @ skin.matrix_world for skin in skins]
            applied_scale.apply(rig_copy, skin_copies, relations, self._times(), np.array(worlds), poses)
        for done, frame in enumerate(self.frames, 1):
            go_to(frame)
            self._compare(skins, skin_copies)
            yield 0.7 + 0.3 * done / len(self.frames)
        self.difference.mean_mm /= len(self.frames) * len(skins)
        self.difference.bare_mean_mm /= len(self.frames) * len(skins)

    def _state_of(self, rig, skins: list) -> RigState:
        """Returns the rig's state in the current frame. Raises SinewError if a skin does not follow its tissues."""
        lookup.objects_named([self.rig, *self._skins], "bake again")
        for skin in skins:
            if session.reason(skin) or session.cached_skin(skin) is None:
                raise SinewError(
                    session.reason(skin) or f"{skin.name} is not part of this scene and view layer. Make it visible"
                )
        return session.cached_rig(rig)

    def _times(self) -> list[float]:
        """The frames as the times of their keys, with Time Remapping."""
        return [frame * time_per_frame(self._context.scene) for frame in self.frames]

    def _key(self, rig_copy, poses: np.ndarray, tensions: np.ndarray, copy_pose: CopyPose):
        """Animates what constraints can't reproduce: muscles with curved paths, and tension. tensions: (frames, tissues)."""
        keyed = [muscle for muscle in self.muscles if muscle.is_keyed]
        times = self._times()
        tense = [
            (muscle, tensions[:, tissue].astype(float))
            for muscle, tissue in zip(self.muscles, copy_pose.indices.tissues, strict=True)
            if not muscle.is_keyed and tensions[:, tissue].any()
        ]
        if keyed or any(np.ptp(tension) for _, tension in tense):
            curves = muscle_keys.copy_curves(rig_copy)
            muscle_keys.key_bones(curves, rig_copy, [muscle.bone for muscle in keyed], times, poses)
        for muscle, tension in tense:
            if np.ptp(tension):
                muscle_keys.key_tension(curves, muscle, times, tension)
            else:
                muscle_keys.hold_tension(rig_copy, muscle, float(tension[0]))

    def _refit(
        self, rig, rig_copy, skin, copy, copy_pose: CopyPose, linear, go_to: Callable[[float], None]
    ) -> Iterator[float]:
        """Refits the baked keys of a copy to its weights. Keys of one joint come before combined keys."""
        keys = copy.data.shape_keys
        all_baked = skin.sinew.skin.baked_keys if keys else ()
        acting = [baked for baked in all_baked if not baked.muted_by_sinew and baked.name in keys.key_blocks]
        acting.sort(key=lambda baked: len(baked.joints.split("\n")))
        key_poses = {baked.name: refit_keys.pose_of(baked) for baked in acting}
        if not acting:
            return
        refit = refit_keys.KeyRefit(copy, linear, session.cached_skin(skin).points, list(key_poses))
        for index, (name, key_pose) in enumerate(key_poses.items()):
            if key_pose is not None and key_pose.frame is not None:
                go_to(key_pose.frame)
                state = self._state_of(rig, [skin])
                pose = copy_pose.matrices(state.pose, state.tension)
                refit.fit(name, pose, _live_points(session.cached_skin(skin), state))
            yield 0.4 + 0.15 * index / len(key_poses)
        angles_of_key = {
            name: key_pose.angles for name, key_pose in key_poses.items() if key_pose is not None and key_pose.frame is None
        }
        if angles_of_key:
            yield from self._refit_correctives(rig, rig_copy, skin, copy_pose, refit, angles_of_key)
        self.unfit += refit.write()

    def _refit_correctives(
        self, rig, rig_copy, skin, copy_pose: CopyPose, refit: refit_keys.KeyRefit, angles_of_key: dict
    ) -> Iterator[float]:
        """Refits keys whose poses are turned joints. angles_of_key: TurnAngles by name."""
        muscle_bone_names = frozenset(name for muscle in self.muscles for name in (muscle.bone, muscle.insertion) if name)
        no_tension = np.zeros_like(session.cached_rig(rig).tension)
        sampler = PoseSampler(rig, [skin])
        try:
            sampler.prepare(
                self._context.scene, rig, list({turn.bone for angles in angles_of_key.values() for turn, _ in angles})
            )
            with refit_keys.rest_pose(rig_copy, muscle_bone_names) as turn_joints:
                for index, (name, angles) in enumerate(angles_of_key.items()):
                    turn_joints(angles)
                    (target,) = sampler.deformed(angles)
                    refit.fit(name, copy_pose.matrices(sampler.pose, no_tension), target)
                    yield 0.55 + 0.15 * index / len(angles_of_key)
        finally:
            sampler.remove()

    def _compare_bare(self, skin, bare, poses: np.ndarray, targets: list):
        """Adds the distances, in all frames, of the skin that has weights for its bones alone."""
        no_offsets, out = np.zeros_like(targets[0]), np.empty_like(targets[0])
        to_world_mm = 1000.0 * np.array(skin.matrix_world.to_3x3()).T
        for pose, target in zip(poses, targets, strict=True):
            bare.deform(pose, no_offsets, out)
            distances_mm = np.linalg.norm((out - target) @ to_world_mm, axis=1)
            self.difference.bare_mean_mm += float(distances_mm.mean())
            self.difference.bare_max_mm = max(self.difference.bare_max_mm, float(distances_mm.max()))

    def _compare(self, skins: list, skin_copies: list):
        """Adds the distances of the copies in the current frame, as Blender evaluates them."""
        depsgraph = self._context.evaluated_depsgraph_get()
        for skin, copy in zip(skins, skin_copies, strict=True):
            live, engine = (_world_points(each.evaluated_get(depsgraph)) for each in (skin, copy))
            if live.shape != engine.shape:
                raise SinewError(
                    f"{skin.name}: its modifiers make {len(engine)} vertices of the copy, {len(live)} of the skin. Apply "
                    "them first, or turn off Merge of a Mirror modifier"
                )
            distances_mm = 1000.0 * np.linalg.norm(live - engine, axis=1)
            self.difference.mean_mm += float(distances_mm.mean())
            self.difference.max_mm = max(self.difference.max_mm, float(distances_mm.max(initial=0.0)))


def _check(rig, skins: list, settings: Settings):
    requirements.require_frames(settings.frame_start, settings.frame_end)
    requirements.require_pose_position(rig)
    if rig.library or any(skin.library for skin in skins):
        raise SinewError(f"{rig.name} is linked from another file. Make it local, or bake it in that file")
    for skin in skins:
        requirements.require_bound(skin)
        requirements.require_object_mode(skin)
        requirements.require_rig(skin, rig)
        modifiers = armature_modifier.armature_modifiers(skin)
        if not modifiers:
            raise SinewError(
                f"{skin.name} has no Armature modifier, so bones can't move it. Parent it to {rig.name} (Ctrl+P)"
            )
        if modifiers[0].vertex_group:
            raise SinewError(
                f"{skin.name}: Armature modifier '{modifiers[0].name}' has a vertex group, which engines do not support. "
                "Clear it"
            )


def _live_points(state: SkinState, rig: RigState) -> np.ndarray:
    """Returns the live skin in the rig's pose, (vertices, 3) float32, mesh space, without the mesh's other keys."""
    out = np.empty_like(state.points)
    state.skin.deform(rig.pose, rig.tension, out)
    return out


def _world_points(evaluated) -> np.ndarray:
    points = mesh_arrays.read_evaluated_points(evaluated.data).astype(np.float64)
    world = np.array(evaluated.matrix_world)
    return points @ world[:3, :3].T + world[:3, 3]
