# SPDX-License-Identifier: GPL-3.0-or-later
"""Reaching over a range of frames, kept as keys: all frames are read, then solved together, then keyed at once."""

from collections.abc import Callable, Iterator

import bpy
import _sinew

from ..errors import SinewError
from ..scene.current_frame import visit_frames
from . import chains, goals, ik_chain, keying

RESTARTS = 16  # in the first frame
# of the work, as far as the progress bar shows it
_READ, _SOLVED = 0.7, 0.8


class ClipBake:
    """One bake. `steps` does the work piece by piece; until it has ended nothing has changed but the current frame."""

    def __init__(self, rig, scene, frames: range, *, smoothness: float, preference: float, pin_feet: bool):
        """Raises SinewError where there are no frames, or nothing that could reach."""
        if not frames:
            raise SinewError(f"the last frame is before the first, {frames.start}: choose a later one")
        if rig.mode == "EDIT":
            raise SinewError(f"{rig.name} is in Edit Mode: leave it (Tab) and bake again")
        if rig.data.pose_position == "REST":
            raise SinewError(f"{rig.name} shows its rest pose: leave Edit Rest Pose and bake again")
        self._rig_name, self._scene, self.frames = rig.name, scene, frames
        self._smoothness, self._preference, self._pin_feet = smoothness, preference, pin_feet
        self._running: Iterator[float] | None = None
        self._empties = [empty.name for empty in goals.goals_of(rig)]
        for empty in goals.goals_of(rig):
            if empty.sinew.goal.bone not in rig.pose.bones:
                raise SinewError(f"{empty.name} is a goal of the bone '{empty.sinew.goal.bone}', which {rig.name} has not")
        if not self._empties and not pin_feet:
            raise SinewError(f"{rig.name} has no goals: select a bone and use Add Goal, or pin its feet")
        if pin_feet and not self._feet(rig):
            raise SinewError(f"{rig.name} has no feet that Sinew knows: put goals on its feet instead of pinning them")
        self.bones: list[str] = []
        self.worst_mm = 0.0

    def steps(self) -> Iterator[float]:
        """Does the work; yields how much of it is done, 0..1. Raises SinewError."""
        self._running = self._bake()
        return self._running

    def _bake(self) -> Iterator[float]:
        with visit_frames(self._scene) as go_to:
            yield from self._solve(go_to)

    def _solve(self, go_to: Callable[[float], None]) -> Iterator[float]:
        read, wanted = [], []
        pins = names = None
        for done, frame in enumerate(self.frames):
            rig, empties, depsgraph = self._at(go_to, frame)
            if pins is None:
                pins = [goals.pin_of(rig, foot) for foot in self._feet(rig)] if self._pin_feet else []
                names = goals.chains_of(rig, empties, pins)
            linkage = ik_chain.read(rig, names)
            read.append(linkage)
            wanted.append(goals.core_goals(rig, linkage, empties, pins, depsgraph))
            yield _READ * (done + 1) / len(self.frames)
        try:
            found = _sinew.reach_clip(
                [linkage.core for linkage in read],
                [each.goals for each in wanted],
                smoothness=self._smoothness,
                preference=self._preference,
                restarts=RESTARTS,
            )
        except ValueError as error:
            raise SinewError(f"{self._rig_name}: {error}; are locks or limits keyed between these frames?") from error
        yield _SOLVED
        rig, *_ = self._at(go_to, self.frames[0])
        scale = max(rig.matrix_world.to_scale())
        for frame, linkage, reached in zip(self.frames, read, found, strict=True):
            linkage.write(rig, reached.angles)
            self.bones = [name for name, joint in zip(linkage.names, linkage.joints, strict=True) if joint]
            keying.key(rig, self.bones, frame)
        misses = [reached.misses[place] for reached, each in zip(found, wanted, strict=True) for place in each.positions]
        self.worst_mm = 1000.0 * scale * max(misses, default=0.0)

    def cancel(self):
        """Between steps: leaves all as it was."""
        if self._running:
            self._running.close()

    def _feet(self, rig) -> list[str]:
        return [bone for (role, _side), bone in chains.ends_of(rig).items() if role == "foot"]

    def _at(self, go_to: Callable[[float], None], frame: int):
        """The rig, its goals and the evaluation at a frame. Names are kept, not references: anything may happen between steps."""
        go_to(frame)
        rig = bpy.data.objects.get(self._rig_name)
        empties = [bpy.data.objects.get(name) for name in self._empties]
        if rig is None or None in empties:
            raise SinewError("the armature or one of its goals was renamed or deleted meanwhile: bake again")
        return rig, empties, bpy.context.evaluated_depsgraph_get()
