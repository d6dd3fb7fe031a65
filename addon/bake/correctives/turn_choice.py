# SPDX-License-Identifier: GPL-3.0-or-later
"""Chooses the joint turns that a bake of correctives samples."""

import math

import numpy as np

from ...errors import SinewError
from ...measure import joint_regions
from ...reach import bone_limits
from ...scene import bone_geometry
from .. import requirements
from ..scratch.joint_turns import JointTurn
from ..scratch.pose_sampler import PoseSampler
from .corrective_settings import Settings
from .skin_keys import SkinKeys
from .turn_ranges import turns_of_joint

# the angle at which it is tested whether a joint has an effect
_TESTED_RAD = math.radians(45.0)


def check(rig, skins: list, settings: Settings):
    """Raises SinewError if the rig is in Edit Mode, a bone is missing, or a mesh follows another rig."""
    if rig.data.is_editmode:
        raise SinewError(f"{rig.name} is in Edit Mode. Leave it (Tab) and bake again")
    requirements.require_pose_position(rig)
    for bone in settings.joints or ():
        if not bone_geometry.has_bone(rig, bone):
            raise SinewError(f"{rig.name} has no bone '{bone}'")
    for skin in skins:
        requirements.require_rig(skin, rig)


def choose_turns(
    scene, rig, skins: list, sampler: PoseSampler, skin_keys: list[SkinKeys], settings: Settings
) -> list[JointTurn]:
    """Returns the turns of all joints to bake and prepares the sampler for them. Raises SinewError if there are none."""
    joints = _joints(rig, skins, sampler, settings)
    sampler.prepare(scene, rig, list(joints))
    if settings.all_joints:
        joints = {bone: joint for bone, joint in joints.items() if _has_effect(rig, joint, sampler, skin_keys, settings)}
    if not joints:
        raise SinewError(f"{rig.name} has no joint with a correction to bake. Name bones, or choose Selected Bones")
    ranges = settings.angles or [""]
    if len(ranges) not in (1, len(joints)):
        raise SinewError(
            f"There are {len(ranges)} ranges of angles for {len(joints)} joints. Give one for all joints, or one for each"
        )
    ranges = ranges * len(joints) if len(ranges) == 1 else ranges
    turns = [
        turn
        for joint, text in zip(joints.values(), ranges, strict=True)
        for turn in turns_of_joint(rig, joint, text, settings.twists)
    ]
    if not turns:
        raise SinewError(f"{', '.join(joints)}: locked on all axes, so there is nothing to rotate")
    return turns


def _joints(rig, skins: list, sampler: PoseSampler, settings: Settings) -> dict[str, joint_regions.Joint]:
    """The joints by bone. A joint of several meshes appears once."""
    bones = settings.joints
    if settings.all_joints:
        bones = [bone.name for bone in rig.data.bones if bone.use_deform and bone.parent]
    joints: dict[str, joint_regions.Joint] = {}
    for skin in skins:
        for joint in joint_regions.joints_of(skin, rig, sampler.rest, sampler.musculature, bones, "MUSCLES"):
            joints.setdefault(joint.bone, joint)
    if not settings.joints:
        # Bones that follow others by constraints do not count as joints, unless all bones do.
        free = joints.keys() - bone_limits.driven_bones(rig)
        joints = {bone: joint for bone, joint in joints.items() if bone in free or not free}
    return joints


def _has_effect(
    rig, joint: joint_regions.Joint, sampler: PoseSampler, skin_keys: list[SkinKeys], settings: Settings
) -> bool:
    """Whether turning a joint gives any mesh a correction above the tolerance."""
    return any(
        keys.mm_per_metre * float(np.linalg.norm(correction, axis=1).max(initial=0.0)) > settings.tolerance_mm
        for turn in turns_of_joint(rig, joint, "", settings.twists)
        for end in (turn.low, turn.high)
        for keys, correction in zip(
            skin_keys, sampler.corrections([(turn, max(min(end, _TESTED_RAD), -_TESTED_RAD))]), strict=True
        )
    )
