# SPDX-License-Identifier: GPL-3.0-or-later
"""Baking a reach over a range of frames to keys: all frames are read, then solved together, then keyed at once."""

from collections.abc import Callable, Generator, Iterator

import bpy
import _sinew

from ..errors import SinewError
from ..scene.current_frame import time_per_frame, visit_frames
from ..scene.lookup import objects_named
from . import chains, goals, ik_chain, keying, reluctance

RESTARTS = 16  # of the first frame
_READ, _SOLVED = 0.7, 0.8  # progress after each of these steps


class ReachBake:
    """One bake. Iterate over `steps` to run it. Until the last step only the current frame changes.

    After the last step, bones: the names of the keyed bones; worst_mm: the largest distance from a position goal, mm.
    """

    def __init__(self, rig, scene, frames: range, *, smoothness: float, preference: float, pin_feet: bool):
        """Raises SinewError if there are no frames, or no goals and no feet to pin."""
        if not frames:
            raise SinewError(f"The last frame is before the first, {frames.start}. Choose a later one")
        if rig.data.is_editmode:
            raise SinewError(f"{rig.name} is in Edit Mode. Leave it (Tab) and bake again")
        if rig.data.pose_position == "REST":
            raise SinewError(f"{rig.name} shows its rest pose. Leave Edit Rest Pose and bake again")
        self._rig_name, self._scene, self.frames = rig.name, scene, frames
        self._smoothness, self._preference, self._pin_feet = smoothness, preference, pin_feet
        self._running: Generator[float] | None = None
        self._empties = [empty.name for empty in goals.goals_of(rig)]
        for empty in goals.goals_of(rig):
            bone = empty.sinew.goal.bone
            if bone not in rig.pose.bones:
                raise SinewError(
                    f"{empty.name} is a goal of the bone '{bone}', which {rig.name} does not have. Choose another"
                )
        if not self._empties and not pin_feet:
            raise SinewError(f"{rig.name} has no goals. Select a bone and use Add Goal, or pin its feet")
        if pin_feet and not self._feet(rig):
            raise SinewError(f"{rig.name} has no feet that Sinew recognises. Add goals to its feet instead of pinning them")
        self.bones: list[str] = []
        self.worst_mm = 0.0

    def steps(self) -> Iterator[float]:
        """Runs the bake and yields the progress, 0..1. Raises SinewError."""
        self._running = self._bake()
        return self._running

    def _bake(self) -> Generator[float]:
        with visit_frames(self._scene) as go_to:
            yield from self._solve(go_to)

    def _solve(self, go_to: Callable[[float], None]) -> Iterator[float]:
        rig_chains, goals_of_frames = [], []
        pins = names = factors = None
        for done, frame in enumerate(self.frames):
            rig, empties, depsgraph = self._at(go_to, frame)
            if pins is None:
                pins = [goals.pin_of(rig, foot) for foot in self._feet(rig)] if self._pin_feet else []
                names = goals.chains_of(rig, empties, pins)
                factors = reluctance.factors(rig, names)
            rig_chain = ik_chain.read(rig, names, factors)
            rig_chains.append(rig_chain)
            goals_of_frames.append(goals.core_goals(rig, rig_chain, empties, pins, depsgraph))
            yield _READ * (done + 1) / len(self.frames)
        try:
            solutions = _sinew.reach_clip(
                [rig_chain.core for rig_chain in rig_chains],
                [frame_goals.goals for frame_goals in goals_of_frames],
                smoothness=self._smoothness,
                preference=self._preference,
                restarts=RESTARTS,
            )
        except ValueError as error:
            raise SinewError(f"{self._rig_name}: {error}; are locks or limits keyed between these frames?") from error
        yield _SOLVED
        rig, *_ = self._at(go_to, self.frames[0])
        scale = max(rig.matrix_world.to_scale())
        for frame, rig_chain, solution in zip(self.frames, rig_chains, solutions, strict=True):
            rig_chain.write(rig, solution.angles)
            self.bones = [name for name, joint in zip(rig_chain.names, rig_chain.joints, strict=True) if joint]
            keying.key(rig, self.bones, frame * time_per_frame(self._scene))
        distances = [
            solution.misses[index]
            for solution, frame_goals in zip(solutions, goals_of_frames, strict=True)
            for index in frame_goals.positions
        ]
        self.worst_mm = 1000.0 * scale * max(distances, default=0.0)

    def cancel(self):
        """Restores the frame. To be called between two steps; nothing else has changed then."""
        if self._running:
            self._running.close()

    def _feet(self, rig) -> list[str]:
        return [bone for (role, _side), bone in chains.ends_of(rig).items() if role == "foot"]

    def _at(self, go_to: Callable[[float], None], frame: int):
        """The rig, its goals and the depsgraph at a frame. Looked up by name, because objects can change between steps."""
        go_to(frame)
        rig, *empties = objects_named([self._rig_name, *self._empties], "bake again")
        return rig, empties, bpy.context.evaluated_depsgraph_get()
