# SPDX-License-Identifier: GPL-3.0-or-later
"""The only reader of bones: a rig's rest pose and its pose as the arrays that the core takes.

A *frame* here is a frame of reference that skin can be weighed to: one a bone, and for a B-Bone one more at each of its
joints. The last frame is the armature itself, which never moves: it stands for the part of a vertex that the vertex
group of an Armature modifier leaves in place.
"""

import re
from dataclasses import dataclass

import _sinew
import numpy as np

from . import skin_regions

ARMATURE_FRAME = "(armature)"
STRAIGHT_ON_RAD = 0.8


@dataclass(frozen=True)
class BendyBone:
    """A B-Bone's joints among the frames: joint k, 0..segments, is frame `first + k`."""

    name: str
    segments: int
    first: int


@dataclass(frozen=True)
class RigRest:
    """A rig's rest pose, read once."""

    skeleton: _sinew.Skeleton
    bone_rest: np.ndarray  # (bones, 4, 4) float32, column-major, in the order of pose bones
    signature: tuple
    frame_of_bone: dict[str, int]
    deforming: frozenset[str]
    bendy: tuple[BendyBone, ...]
    segments: np.ndarray  # (frames,) int32: bones of one number are one segment of the body
    lengths: np.ndarray  # (frames,) float32, armature space
    size: float  # largest extent of the bones, in armature space

    @property
    def armature_frame(self) -> int:
        return len(self.skeleton) - 1

    def bendy_bone(self, name: str) -> BendyBone | None:
        return next((bendy for bendy in self.bendy if bendy.name == name), None)


def is_resting(rig) -> bool:
    """Whether a rig shows its rest pose, by its own switch or because no bone is posed."""
    if rig.data.pose_position == "REST":
        return True
    basis = np.empty((len(rig.pose.bones), 4, 4), np.float32)
    rig.pose.bones.foreach_get("matrix_basis", basis.reshape(-1))
    return bool(np.abs(basis - np.eye(4)).max(initial=0.0) < 1e-6)


def signature(rig) -> tuple:
    """Names, deform switches and B-Bone segments of a rig's bones; cheap enough to compare at every frame.

    Parents are not in it: they change in Edit Mode alone, after which a rig is read again anyway.
    """
    bones = rig.data.bones
    deforms, segments = np.empty(len(bones), bool), np.empty(len(bones), np.int32)
    bones.foreach_get("use_deform", deforms)
    bones.foreach_get("bbone_segments", segments)
    return bones.keys(), deforms.tobytes(), segments.tobytes()


def rest_matrices(rig) -> np.ndarray:
    """(bones, 4, 4) float32, column-major: the rest pose in the order of the armature's bones."""
    matrices = np.empty((len(rig.data.bones), 4, 4), np.float32)
    rig.data.bones.foreach_get("matrix_local", matrices.reshape(-1))
    return matrices


def read_rest(rig) -> RigRest:
    """The rest pose of a rig. Raises ValueError (of the core) where a bone's rest matrix can't be inverted."""
    pose_bones = rig.pose.bones
    names = [bone.name for bone in pose_bones]
    in_data = {bone.name: index for index, bone in enumerate(rig.data.bones)}
    bone_rest = rest_matrices(rig)
    rest = [bone_rest[in_data[name]] for name in names]
    frame_of_bone = {name: index for index, name in enumerate(names)}
    parents = [frame_of_bone[bone.parent.name] if bone.parent else -1 for bone in pose_bones]
    bendy = []
    for bone in pose_bones:
        segments = bone.bone.bbone_segments
        if segments < 2:
            continue
        bendy.append(BendyBone(bone.name, segments, len(rest)))
        for joint in range(segments + 1):
            matrix = bone.bone.matrix_local @ bone.bbone_segment_matrix(joint, rest=True)
            rest.append(np.array(matrix.transposed(), np.float32))
            names.append(f"{bone.name} (joint {joint})")
            parents.append(frame_of_bone[bone.name])
    rest.append(np.eye(4, dtype=np.float32))
    names.append(ARMATURE_FRAME)
    parents.append(-1)
    ends = np.array([end for bone in rig.data.bones for end in (bone.head_local, bone.tail_local)])
    return RigRest(
        skeleton=_sinew.Skeleton(names, np.array(parents, np.int32), np.array(rest, np.float32)),
        bone_rest=bone_rest,
        signature=signature(rig),
        frame_of_bone=frame_of_bone,
        deforming=frozenset(bone.name for bone in rig.data.bones if bone.use_deform),
        bendy=tuple(bendy),
        segments=_segments(rig, pose_bones, frame_of_bone, len(rest)),
        lengths=np.array([bone.bone.length for bone in pose_bones] + [0.0] * (len(rest) - len(pose_bones)), np.float32),
        size=float(np.ptp(ends, axis=0).max()),
    )


def _segments(rig, pose_bones, frame_of_bone: dict[str, int], count: int) -> np.ndarray:
    """The segment of each frame: a bone that goes straight on from one of the same name, but for a number or "twist"."""
    segments = np.arange(count, dtype=np.int32)
    for bone in pose_bones:
        parent = bone.parent
        if parent is None or _stem(bone.name) != _stem(parent.name):
            continue
        axis, above = bone.bone.matrix_local.col[1].to_3d(), parent.bone.matrix_local.col[1].to_3d()
        beyond = (bone.bone.head_local - parent.bone.head_local).length >= 0.2 * parent.bone.length
        if axis.angle(above) < STRAIGHT_ON_RAD and beyond:
            segments[frame_of_bone[bone.name]] = segments[frame_of_bone[parent.name]]
    return segments


def _stem(name: str) -> str:
    return re.sub(r"twist|[\d\s._-]", "", name.lower())


def read_pose(evaluated_rig, rest: RigRest, pose: np.ndarray):
    """Fills `pose`, (frames, 4, 4) float32 column-major, with the evaluated pose of all frames."""
    bones = evaluated_rig.pose.bones
    bones.foreach_get("matrix", pose[: len(bones)].reshape(-1))
    for bendy in rest.bendy:
        bone = bones[bendy.name]
        for joint in range(bendy.segments + 1):
            pose[bendy.first + joint] = (bone.matrix @ bone.bbone_segment_matrix(joint)).transposed()
    pose[rest.armature_frame] = np.eye(4, dtype=np.float32)


def read_bone_settings(rig, rest: RigRest) -> dict[str, np.ndarray]:
    """(frames,) float32 each: what a person set on a rig's bones, by `skin_regions.OF_BONE`; what is 1 on all is left out.

    The joints of a B-Bone have its settings.
    """
    # asked so, a bone without settings is left without a trace
    told = [(rest.frame_of_bone[bone.name], bone.sinew) for bone in rig.pose.bones if bone.is_property_set("sinew")]
    settings = {}
    for name in skin_regions.OF_BONE:
        factors = np.ones(len(rest.skeleton), np.float32)
        for frame, own in told:
            factors[frame] = getattr(own, name)
        for bendy in rest.bendy:
            factors[bendy.first : bendy.first + bendy.segments + 1] = factors[rest.frame_of_bone[bendy.name]]
        if (factors != 1.0).any():
            settings[name] = factors
    return settings
