# SPDX-License-Identifier: GPL-3.0-or-later
"""A drag: one bone's end is pulled about, its chain follows in every step, and all can be put back."""

import _sinew
import numpy as np
from mathutils import Vector

from ..errors import SinewError
from . import chains, ik_chain

MOST_ROUNDS = 12
RESTARTS = 16
# float32 of Blender's matrices, of the distance from the world's origin
SHOWN_WITHIN = 1e-5


class Drag:
    """A chain that follows a target. It prefers the pose at the beginning, or the rest pose: a drag leaves no trace of its way."""

    def __init__(
        self, rig, bone: str, *, length: int, at_tail: bool, keep_orientation: bool = False, prefers_rest: bool = False
    ):
        """Raises SinewError where the chain can't turn."""
        if rig.mode == "EDIT":
            raise SinewError(f"{rig.name} is in Edit Mode: leave it (Tab) and reach again")
        if rig.data.pose_position == "REST":
            raise SinewError(f"{rig.name} shows its rest pose: leave Edit Rest Pose and reach again")
        self.bone, self.at_tail = bone, at_tail
        self._names = chains.chain_of(rig, bone, length)
        first = ik_chain.read(rig, self._names)
        self._preferred = first.rest_angles() if prefers_rest else first.core.angles
        self._before = {name: _channels(rig.pose.bones[name]) for name in self._names}
        pose_bone = rig.pose.bones[bone]
        self._point = tuple(ik_chain.end_point(pose_bone, at_tail))
        self._orientation = tuple(pose_bone.matrix.to_quaternion()) if keep_orientation else None
        self.moved: set[str] = set()

    @property
    def length(self) -> int:
        """How many bones take part."""
        return len(self._names)

    def end_world(self, rig) -> Vector:
        """Where the dragged end is, world space."""
        bone = rig.pose.bones[self.bone]
        return rig.matrix_world @ (bone.tail if self.at_tail else bone.head)

    def pull(self, rig, target_world: Vector, *, preference: float, restarts: int = 0) -> float:
        """Brings the bone's end to a place in the world, or as near as it gets; returns how far it is from it, world space.

        Raises SinewError.
        """
        linkage = ik_chain.read(rig, self._names)
        joint = linkage.names.index(self.bone)
        target = rig.matrix_world.inverted_safe() @ target_world
        wanted = [_sinew.Goal(joint, "POSITION", tuple(target), point=self._point)]
        if self._orientation:
            wanted.append(_sinew.Goal(joint, "ORIENTATION", self._orientation))
        try:
            found = _sinew.reach(linkage.core, wanted, self._preferred, preference=preference, restarts=restarts)
        except ValueError as error:
            raise SinewError(f"{rig.name}: {error}") from error
        self.moved.update(linkage.write(rig, found.angles))
        return found.misses[0] * max(rig.matrix_world.to_scale())

    def settle(self, view_layer, rig, target_world: Vector, *, preference: float) -> float:
        """As `pull`, from other poses too where the goal is missed, until Blender shows the bone's end where it was computed.

        One round, but where bones inherit part of a scale that is uneven: a joint's own turning then changes its child's shape.
        """
        for _ in range(MOST_ROUNDS):
            miss = self.pull(rig, target_world, preference=preference, restarts=RESTARTS)
            view_layer.update()
            shown = (self.end_world(rig) - target_world).length
            if shown <= miss + SHOWN_WITHIN * target_world.length + SHOWN_WITHIN:
                break
            self._preferred = None  # from now on the smallest change, so that each round begins nearer
        return shown

    def put_back(self, rig):
        """Leaves the pose as it was at the beginning."""
        for name, channels in self._before.items():
            for path, value in channels.items():
                setattr(rig.pose.bones[name], path, value)
        self.moved.clear()


def reset(rig, names: list[str]) -> list[str]:
    """Brings bones to the rest pose, as near as their limits and locks allow; returns those that turned. Raises SinewError."""
    linkage = ik_chain.read(rig, names)
    return linkage.write(rig, linkage.rest_angles())


def _channels(bone) -> dict:
    return {
        "rotation_quaternion": bone.rotation_quaternion.copy(),
        "rotation_euler": bone.rotation_euler.copy(),
        "rotation_axis_angle": np.array(bone.rotation_axis_angle),
    }
