# SPDX-License-Identifier: GPL-3.0-or-later
"""Dragging the end of a bone: its chain follows in each step, and the pose can be restored."""

import _sinew
import numpy as np
from mathutils import Vector

from ..errors import SinewError
from . import chains, ik_chain, reluctance

MOST_PASSES = 12
RESTARTS = 16
# Error of Blender's float32 matrices, as a fraction of the distance from the world's origin.
MATRIX_ERROR = 1e-5


class Drag:
    """A chain that follows a target.

    In each step it prefers the pose at the start of the drag, or the rest pose, so that the result depends on the target and
    not on the path that it took.
    """

    def __init__(
        self, rig, bone: str, *, length: int, at_tail: bool, keep_orientation: bool = False, prefers_rest: bool = False
    ):
        """length: number of bones, 0 for all up to the pelvis. at_tail: drags the bone's tail, not its head.

        Raises SinewError if no bone of the chain can rotate.
        """
        if rig.data.is_editmode:
            raise SinewError(f"{rig.name} is in Edit Mode. Leave it (Tab) and reach again")
        if rig.data.pose_position == "REST":
            raise SinewError(f"{rig.name} shows its rest pose. Leave Edit Rest Pose and reach again")
        self.bone, self.at_tail = bone, at_tail
        self._names = chains.chain_of(rig, bone, length)
        self._factors = reluctance.factors(rig, self._names)
        first = ik_chain.read(rig, self._names, self._factors)
        self._preferred = first.rest_angles() if prefers_rest else first.core.angles
        self._before = {name: _channels(rig.pose.bones[name]) for name in self._names}
        pose_bone = rig.pose.bones[bone]
        self._point = tuple(ik_chain.end_point(pose_bone, at_tail))
        self._orientation = tuple(pose_bone.matrix.to_quaternion()) if keep_orientation else None
        self.moved: set[str] = set()

    @property
    def length(self) -> int:
        """The number of bones in the chain."""
        return len(self._names)

    def end_world(self, rig) -> Vector:
        """The position of the dragged end, world space."""
        bone = rig.pose.bones[self.bone]
        return rig.matrix_world @ (bone.tail if self.at_tail else bone.head)

    def pull(self, rig, target_world: Vector, *, preference: float, restarts: int = 0) -> float:
        """Moves the bone's end as close as possible to a target. Returns the computed distance from it. World space.

        Raises SinewError.
        """
        rig_chain = ik_chain.read(rig, self._names, self._factors)
        joint = rig_chain.names.index(self.bone)
        target = rig.matrix_world.inverted_safe() @ target_world
        goals = [_sinew.Goal(joint, "POSITION", tuple(target), point=self._point)]
        if self._orientation:
            goals.append(_sinew.Goal(joint, "ORIENTATION", self._orientation))
        try:
            reached = _sinew.reach(rig_chain.core, goals, self._preferred, preference=preference, restarts=restarts)
        except ValueError as error:
            raise SinewError(f"{rig.name}: {error}") from error
        self.moved.update(rig_chain.write(rig, reached.angles))
        return reached.misses[0] * max(rig.matrix_world.to_scale())

    def settle(self, view_layer, rig, target_world: Vector, *, preference: float) -> float:
        """As `pull`, with restarts from other poses, until Blender's pose agrees with the computed one.

        Returns the distance from the target in Blender's pose, world space. One pass is enough unless bones inherit part
        of a non-uniform scale: then the rotation of a joint changes the shape of its child.
        """
        for _ in range(MOST_PASSES):
            computed = self.pull(rig, target_world, preference=preference, restarts=RESTARTS)
            view_layer.update()
            shown = (self.end_world(rig) - target_world).length
            if shown <= computed + MATRIX_ERROR * target_world.length + MATRIX_ERROR:
                break
            self._preferred = None  # prefers the smallest change from here on, so that the passes converge
        return shown

    def put_back(self, rig):
        """Restores the pose at the start of the drag."""
        for name, channels in self._before.items():
            for path, value in channels.items():
                setattr(rig.pose.bones[name], path, value)
        self.moved.clear()


def reset(rig, names: list[str]) -> list[str]:
    """Rotates bones to the rest pose, as far as their limits and locks allow. Returns the names of the rotated bones.

    Raises SinewError.
    """
    rig_chain = ik_chain.read(rig, names)
    return rig_chain.write(rig, rig_chain.rest_angles())


def _channels(bone) -> dict:
    return {
        "rotation_quaternion": bone.rotation_quaternion.copy(),
        "rotation_euler": bone.rotation_euler.copy(),
        "rotation_axis_angle": np.array(bone.rotation_axis_angle),
    }
