# SPDX-License-Identifier: GPL-3.0-or-later
"""The rest pose and the current pose of a rig, as arrays for the core.

The core's skeleton has more bones than the rig. First come the rig's bones, in the order of its pose bones. Then come the
joints of each B-Bone's segments, one bone per joint. The last is the armature itself, which never moves: a vertex has
weights on it if the vertex group of the Armature modifier excludes a part of that vertex.
"""

import re
from dataclasses import dataclass

import _sinew
import numpy as np

from ..errors import SinewError
from . import skin_regions, stored_settings

ARMATURE_NAME = "(armature)"
# two bones of one segment differ by less than this angle, and their heads are at least this fraction of a bone apart
LARGEST_ANGLE_IN_SEGMENT_RAD = 0.8
SHORTEST_OF_PARENT = 0.2


@dataclass(frozen=True)
class BendyBone:
    """The joints of a B-Bone in the skeleton: joint k, 0..segments, is bone `first + k`."""

    name: str
    segments: int
    first: int


@dataclass(frozen=True)
class RigRest:
    """The rest pose of a rig. Arrays with one row per bone follow the order of the skeleton."""

    skeleton: _sinew.Skeleton
    bone_rest: np.ndarray  # (bones, 4, 4) float32, column-major, in the order of pose bones
    signature: tuple
    index_of_bone: dict[str, int]
    deforming: frozenset[str]
    bendy: tuple[BendyBone, ...]
    segments: np.ndarray  # (skeleton bones,) int32: bones with the same number are one segment of the body
    parents: np.ndarray  # (skeleton bones,) int32
    joints: np.ndarray  # (skeleton bones, 4, 4) float32, column-major: the rest matrices of the skeleton
    lengths: np.ndarray  # (skeleton bones,) float32, armature space; 0 for joints of B-Bones and the armature
    size: float  # largest side of the bounding box of the bones, armature space

    def is_same(self, other: "RigRest") -> bool:
        """Whether another rest pose is the same in all that is read from a rig."""
        exact = ("signature", "index_of_bone", "deforming", "bendy", "size")
        arrays = ("bone_rest", "segments", "parents", "joints", "lengths")
        return all(getattr(self, name) == getattr(other, name) for name in exact) and all(
            np.array_equal(getattr(self, name), getattr(other, name)) for name in arrays
        )

    @property
    def armature_index(self) -> int:
        """The index of the armature in the skeleton."""
        return len(self.skeleton) - 1

    def bendy_bone(self, name: str) -> BendyBone | None:
        """The B-Bone with this name, or None if the bone is not a B-Bone."""
        return next((bendy for bendy in self.bendy if bendy.name == name), None)


def size_of(rig) -> float:
    """The largest extent of a rig's bones along an axis of armature space. Raises SinewError for a rig without bones."""
    ends = [end for bone in rig.data.bones for end in (bone.head_local, bone.tail_local)]
    if not ends:
        raise SinewError(f"{rig.name} has no bones: add some in Edit Mode")
    return max(max(end[axis] for end in ends) - min(end[axis] for end in ends) for axis in range(3))


def is_resting(rig) -> bool:
    """Whether a rig shows its rest pose, because it is set to Rest Position or no bone is posed."""
    if rig.data.pose_position == "REST":
        return True
    basis = np.empty((len(rig.pose.bones), 4, 4), np.float32)
    rig.pose.bones.foreach_get("matrix_basis", basis.reshape(-1))
    return bool(np.abs(basis - np.eye(4)).max(initial=0.0) < 1e-6)


def signature(rig) -> tuple:
    """Names, deform switches and B-Bone segments of a rig's bones. Cheap enough to compare in every frame.

    Parents are not included: they change only in Edit Mode, and after Edit Mode a rig is read again.
    """
    bones = rig.data.bones
    deforms, segments = np.empty(len(bones), bool), np.empty(len(bones), np.int32)
    bones.foreach_get("use_deform", deforms)
    bones.foreach_get("bbone_segments", segments)
    return bones.keys(), deforms.tobytes(), segments.tobytes()


def rest_matrices(rig) -> np.ndarray:
    """(bones, 4, 4) float32, column-major: the rest matrices in the order of the armature's bones."""
    matrices = np.empty((len(rig.data.bones), 4, 4), np.float32)
    rig.data.bones.foreach_get("matrix_local", matrices.reshape(-1))
    return matrices


def read_rest(rig) -> RigRest:
    """Reads the rest pose of a rig.

    Raises ValueError (from the core) if a bone's rest matrix can't be inverted, and SinewError for a rig without bones, or
    with the pose of other bones.
    """
    pose_bones = rig.pose.bones
    names = [bone.name for bone in pose_bones]
    in_data = {bone.name: index for index, bone in enumerate(rig.data.bones)}
    unknown = [name for name in names if name not in in_data]
    if unknown:
        # Blender keeps the old pose of an object whose armature changed through another object, as undo can do
        raise SinewError(
            f"{rig.name}: its pose has the bones {', '.join(unknown)}, which its armature {rig.data.name} no longer has. "
            "Enter and leave Edit Mode (Tab), so that Blender reads its bones again"
        )
    bone_rest = rest_matrices(rig)
    rest = [bone_rest[in_data[name]] for name in names]
    index_of_bone = {name: index for index, name in enumerate(names)}
    parents = [index_of_bone[bone.parent.name] if bone.parent else -1 for bone in pose_bones]
    bendy = []
    for bone in pose_bones:
        segments = bone.bone.bbone_segments
        if segments < 2:
            continue
        bendy.append(BendyBone(bone.name, segments, len(rest)))
        for joint in range(segments + 1):
            try:
                matrix = bone.bone.matrix_local @ bone.bbone_segment_matrix(joint, rest=True)
            except RuntimeError as error:  # its number of segments changed, and Blender has not evaluated the pose since
                raise SinewError(f"{rig.name}: {str(error).strip()}") from error
            rest.append(np.array(matrix.transposed(), np.float32))
            names.append(f"{bone.name} (joint {joint})")
            parents.append(index_of_bone[bone.name])
    rest.append(np.eye(4, dtype=np.float32))
    names.append(ARMATURE_NAME)
    parents.append(-1)
    parents_of, joints = np.array(parents, np.int32), np.array(rest, np.float32)
    return RigRest(
        skeleton=_sinew.Skeleton(names, parents_of, joints),
        bone_rest=bone_rest,
        signature=signature(rig),
        index_of_bone=index_of_bone,
        deforming=frozenset(bone.name for bone in rig.data.bones if bone.use_deform),
        bendy=tuple(bendy),
        segments=_segments(rig, pose_bones, index_of_bone, len(rest)),
        parents=parents_of,
        joints=joints,
        lengths=np.array([bone.bone.length for bone in pose_bones] + [0.0] * (len(rest) - len(pose_bones)), np.float32),
        size=size_of(rig),
    )


def _segments(rig, pose_bones, index_of_bone: dict[str, int], count: int) -> np.ndarray:
    """(count,) int32: the segment of each bone of the skeleton.

    A bone belongs to its parent's segment if it continues the parent's direction and both names are equal except for
    numbers and the word "twist".
    """
    segments = np.arange(count, dtype=np.int32)
    for bone in pose_bones:
        parent = bone.parent
        if parent is None or _stem(bone.name) != _stem(parent.name):
            continue
        axis, parent_axis = bone.bone.matrix_local.col[1].to_3d(), parent.bone.matrix_local.col[1].to_3d()
        distance = (bone.bone.head_local - parent.bone.head_local).length
        is_beyond = distance >= SHORTEST_OF_PARENT * parent.bone.length
        if axis.angle(parent_axis) < LARGEST_ANGLE_IN_SEGMENT_RAD and is_beyond:
            segments[index_of_bone[bone.name]] = segments[index_of_bone[parent.name]]
    return segments


def _stem(name: str) -> str:
    return re.sub(r"twist|[\d\s._-]", "", name.lower())


def read_pose(evaluated_rig, rest: RigRest, pose: np.ndarray):
    """Fills `pose`, (skeleton bones, 4, 4) float32 column-major, with the evaluated pose in armature space."""
    bones = evaluated_rig.pose.bones
    bones.foreach_get("matrix", pose[: len(bones)].reshape(-1))
    for bendy in rest.bendy:
        bone = bones[bendy.name]
        for joint in range(bendy.segments + 1):
            pose[bendy.first + joint] = (bone.matrix @ bone.bbone_segment_matrix(joint)).transposed()
    pose[rest.armature_index] = np.eye(4, dtype=np.float32)


def bones_without_position(rest: RigRest, pose: np.ndarray) -> list[str]:
    """The names of the bones whose pose is not finite, or no transform. pose: as from `read_pose`."""
    is_lost = ~np.isfinite(pose).all(axis=(1, 2)) | (pose[:, :, 3] != (0.0, 0.0, 0.0, 1.0)).any(axis=1)
    names = [name for name, index in rest.index_of_bone.items() if is_lost[index]]
    joints = [bendy.name for bendy in rest.bendy if is_lost[bendy.first : bendy.first + bendy.segments + 1].any()]
    return list(dict.fromkeys(names + joints))


def read_bone_settings(rig, rest: RigRest) -> dict[str, np.ndarray]:
    """The skin settings of a rig's bones by name (`skin_regions.OF_BONE`), (skeleton bones,) float32 each.

    Settings that are 1 on all bones are left out. The joints of a B-Bone have the settings of the B-Bone.
    """
    all_settings = [(rest.index_of_bone[bone.name], stored_settings.bone_of(bone)) for bone in rig.pose.bones]
    settings = {}
    for name in skin_regions.OF_BONE:
        factors = np.ones(len(rest.skeleton), np.float32)
        for index, of_bone in all_settings:
            if of_bone is not None:
                factors[index] = getattr(of_bone, name)
        for bendy in rest.bendy:
            factors[bendy.first : bendy.first + bendy.segments + 1] = factors[rest.index_of_bone[bendy.name]]
        if (factors != 1.0).any():
            settings[name] = factors
    return settings
