# SPDX-License-Identifier: GPL-3.0-or-later
"""A rig's pose as the linkage that the core solves, and a solved pose back on the rig's bones.

Bones are read as rig_io reads them, from the pose that Blender evaluated, so scaled and turned parents, B-Bones, bones that
don't inherit rotation or scale, and other constraints above a chain are in it.
"""

from dataclasses import dataclass

import _sinew
import numpy as np
from mathutils import Matrix, Quaternion, Vector

from ..errors import SinewError
from . import bone_limits
from .bone_limits import JointOfBone

# a rotation about no bone's own axis
PROBE = Quaternion((0.8, 0.3, -0.4, 0.33)).normalized()


@dataclass(frozen=True)
class RigChain:
    """The bones of a linkage, in its order, and what of each is read."""

    core: _sinew.Linkage
    names: tuple[str, ...]
    joints: tuple[JointOfBone | None, ...]  # None: something else turns the bone

    def rest_angles(self) -> np.ndarray:
        """(joints, 3) the rest pose, within the limits."""
        return np.array([bone_limits.rest_angles(joint) if joint else (0.0, 0.0, 0.0) for joint in self.joints])

    def write(self, rig, angles: np.ndarray) -> list[str]:
        """Turns the rig's bones to (joints, 3) angles; returns the names of those that turned."""
        moved = []
        for name, joint, turned in zip(self.names, self.joints, angles, strict=True):
            if joint and bone_limits.write(rig.pose.bones[name], joint.freedoms, tuple(turned)):
                moved.append(name)
        return moved


def read(rig, names: list[str]) -> RigChain:
    """The linkage of some bones, parents before children, in the evaluated pose. Raises SinewError.

    A bone whose parent is not among them hangs on where that stands now.
    """
    places = {name: place for place, name in enumerate(names)}
    driven = bone_limits.driven_bones(rig)
    read_joints, parents, sockets, turns, scales = [], [], [], [], []
    for name in names:
        bone = rig.pose.bones[name]
        parent = bone.parent if bone.parent and bone.parent.name in places else None
        joint = None if name in driven else bone_limits.joint_of(bone)
        stands, scale = _at_zero(bone) if joint else (bone.matrix.copy(), (1.0, 1.0, 1.0))
        # what something else turns is taken to be fixed to its parent
        turns_along = parent is None or bone.bone.use_inherit_rotation or joint is None
        if parent:
            inside = _inverted(parent) @ stands
            stands = inside if turns_along else Matrix.Translation(inside.translation) @ stands.to_3x3().to_4x4()
        read_joints.append(joint)
        parents.append(places[parent.name] if parent else -1)
        sockets.append(np.array(stands.transposed(), np.float64))
        turns.append(turns_along)
        scales.append(tuple(scale))
    still = JointOfBone("BALL", (0.0,) * 3, (0.0,) * 3, (0.0,) * 3, 1.0)
    known = [joint or still for joint in read_joints]
    try:
        core = _sinew.Linkage(
            names,
            np.array(parents, np.int32),
            np.array(sockets).reshape(-1, 4, 4),
            [joint.freedoms for joint in known],
            np.array([joint.angles for joint in known], np.float64).reshape(-1, 3),
            np.array([joint.lower for joint in known], np.float64).reshape(-1, 3),
            np.array([joint.upper for joint in known], np.float64).reshape(-1, 3),
            scales=np.array(scales, np.float64).reshape(-1, 3),
            multipliers=np.array([joint.multiplier for joint in known]),
            turns_with_parent=turns,
        )
    except ValueError as error:
        raise SinewError(f"{rig.name}: {error}") from error
    if core.freedom_count == 0:
        raise SinewError(
            f"{rig.name}: none of the bones {', '.join(names)} can turn: all are locked, or turned by constraints; "
            "unlock one, or make the chain longer"
        )
    return RigChain(core, tuple(names), tuple(read_joints))


def end_point(bone, at_tail: bool) -> Vector:
    """A pose bone's tail or head in its own posed axes."""
    return Vector((0.0, bone.bone.length, 0.0)) if at_tail else Vector()


def _at_zero(bone) -> tuple[Matrix, Vector]:
    """Where a pose bone would stand, armature space, with its location but no rotation of its own; and its scale after that."""
    location = Matrix.Translation(bone.matrix_basis.translation)
    stands, scale = _posed(bone, location), bone.scale.copy()
    if bone.bone.inherit_scale == "FULL":
        return stands, scale
    # some ways to inherit scale have it act before the bone's own rotation, some after: seen from one that is turned
    inherited = Vector(column.length for column in stands.to_3x3().col)
    unscaled = stands.copy()
    unscaled.col[0], unscaled.col[1], unscaled.col[2] = (stands.col[axis] / inherited[axis] for axis in range(3))
    turn = PROBE.to_matrix().to_4x4()
    shown = _posed(bone, location @ turn)
    before = _difference(shown, stands @ turn)
    after = _difference(shown, unscaled @ turn @ Matrix.Diagonal((*inherited, 1.0)))
    return (unscaled, scale * inherited) if after < before else (stands, scale)


def _posed(bone, basis: Matrix) -> Matrix:
    """Where Blender would place a pose bone with another basis."""
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
        raise SinewError(f"the bone '{bone.name}' has a scale of 0: give it a size") from error
