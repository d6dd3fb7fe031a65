# SPDX-License-Identifier: GPL-3.0-or-later
"""The bones of a rig as an IK chain that the core solves, and a solved pose written to the bones.

Bones are read from the pose that Blender evaluated, as in `scene.rig_pose`. Scaled and rotated parents, B-Bones, bones
that do not inherit rotation or scale, and constraints above the chain are therefore taken into account. The problem that
the core solves is described in docs/mathematics/reach.md.
"""

from dataclasses import dataclass

import _sinew
import numpy as np
from mathutils import Matrix, Quaternion, Vector

from ..errors import SinewError
from . import bone_limits
from .bone_limits import BoneJoint

# An arbitrary rotation, not about an axis of a bone.
PROBE = Quaternion((0.8, 0.3, -0.4, 0.33)).normalized()


@dataclass(frozen=True)
class RigChain:
    """Bones of a rig as an IK chain. All tuples have the order of the chain's joints, parents before children."""

    core: _sinew.Linkage
    names: tuple[str, ...]
    joints: tuple[BoneJoint | None, ...]  # None: a constraint rotates the bone

    def rest_angles(self) -> np.ndarray:
        """(joints, 3) float64, radians: the rest pose, within the limits."""
        return np.array([bone_limits.rest_angles(joint) if joint else (0.0, 0.0, 0.0) for joint in self.joints])

    def write(self, rig, angles: np.ndarray) -> list[str]:
        """Rotates the rig's bones to (joints, 3) angles. Returns the names of the bones that changed."""
        rotated = []
        for name, joint, bone_angles in zip(self.names, self.joints, angles, strict=True):
            if joint and bone_limits.write(rig.pose.bones[name], joint.parameterisation, tuple(bone_angles)):
                rotated.append(name)
        return rotated


def read(rig, names: list[str], factors: np.ndarray | None = None) -> RigChain:
    """The IK chain of these bones, parents before children, in the evaluated pose. Raises SinewError.

    A bone whose parent is not among them is fixed to the parent's current position. factors: on the eagerness of each joint,
    as of `reluctance`.
    """
    index_of = {name: index for index, name in enumerate(names)}
    driven = bone_limits.driven_bones(rig)
    bone_joints, parents, sockets, turns, scales = [], [], [], [], []
    for name in names:
        bone = rig.pose.bones[name]
        parent = bone.parent if bone.parent and bone.parent.name in index_of else None
        joint = None if name in driven else bone_limits.joint_of(bone)
        socket, scale = _at_zero(bone) if joint else (bone.matrix.copy(), (1.0, 1.0, 1.0))
        # a bone that a constraint rotates counts as fixed to its parent
        turns_with_parent = parent is None or bone.bone.use_inherit_rotation or joint is None
        if parent:
            in_parent = _inverted(parent) @ socket
            if turns_with_parent:
                socket = in_parent
            else:
                socket = Matrix.Translation(in_parent.translation) @ socket.to_3x3().to_4x4()
        bone_joints.append(joint)
        parents.append(index_of[parent.name] if parent else -1)
        sockets.append(np.array(socket.transposed(), np.float64))
        turns.append(turns_with_parent)
        scales.append(tuple(scale))
    fixed = BoneJoint("BALL", (0.0,) * 3, (0.0,) * 3, (0.0,) * 3, 1.0)
    joints = [joint or fixed for joint in bone_joints]
    eagerness = np.array([joint.eagerness for joint in joints])
    if factors is not None:
        eagerness = np.maximum(eagerness * factors, bone_limits.SMALLEST_EAGERNESS)
    try:
        core = _sinew.Linkage(
            names,
            np.array(parents, np.int32),
            np.array(sockets).reshape(-1, 4, 4),
            [joint.parameterisation for joint in joints],
            np.array([joint.angles for joint in joints], np.float64).reshape(-1, 3),
            np.array([joint.lower for joint in joints], np.float64).reshape(-1, 3),
            np.array([joint.upper for joint in joints], np.float64).reshape(-1, 3),
            scales=np.array(scales, np.float64).reshape(-1, 3),
            eagerness=eagerness,
            turns_with_parent=turns,
        )
    except ValueError as error:
        raise SinewError(f"{rig.name}: {error}") from error
    if core.freedom_count == 0:
        raise SinewError(
            f"{rig.name}: none of the bones {', '.join(names)} can rotate: all are locked, or rotated by constraints. "
            "Unlock one, or make the chain longer"
        )
    return RigChain(core, tuple(names), tuple(bone_joints))


def end_point(bone, at_tail: bool) -> Vector:
    """The tail or head of a pose bone in its posed axes."""
    return Vector((0.0, bone.bone.length, 0.0)) if at_tail else Vector()


def _at_zero(bone) -> tuple[Matrix, Vector]:
    """The matrix of a pose bone without its rotation, armature space, and the scale that acts after its rotation."""
    location = Matrix.Translation(bone.matrix_basis.translation)
    socket, scale = _posed(bone, location), bone.scale.copy()
    if bone.bone.inherit_scale == "FULL":
        return socket, scale
    # Depending on its mode, an inherited scale acts before or after the bone's rotation. A probe rotation shows which.
    inherited = Vector(column.length for column in socket.to_3x3().col)
    unscaled = socket.copy()
    unscaled.col[0], unscaled.col[1], unscaled.col[2] = (socket.col[axis] / inherited[axis] for axis in range(3))
    rotation = PROBE.to_matrix().to_4x4()
    posed = _posed(bone, location @ rotation)
    before = _difference(posed, socket @ rotation)
    after = _difference(posed, unscaled @ rotation @ Matrix.Diagonal((*inherited, 1.0)))
    return (unscaled, scale * inherited) if after < before else (socket, scale)


def _posed(bone, basis: Matrix) -> Matrix:
    """The matrix that Blender gives a pose bone with another basis matrix, armature space."""
    if bone.parent is None:
        return bone.bone.convert_local_to_pose(basis, bone.bone.matrix_local)
    return bone.bone.convert_local_to_pose(
        basis, bone.bone.matrix_local, parent_matrix=bone.parent.matrix, parent_matrix_local=bone.parent.bone.matrix_local
    )


def _difference(first: Matrix, second: Matrix) -> float:
    return max((a - b).length for a, b in zip(first.col, second.col, strict=True))


def _inverted(bone) -> Matrix:
    try:
        return bone.matrix.inverted()
    except ValueError as error:
        raise SinewError(f"The bone '{bone.name}' has a scale of 0. Give it a scale above 0 on all axes") from error
