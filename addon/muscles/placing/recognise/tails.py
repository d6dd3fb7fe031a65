# SPDX-License-Identifier: GPL-3.0-or-later
"""A tail that no name tells: the longest chain of bones in the middle of the body that starts at the pelvis and holds
nothing.
"""

from collections.abc import Mapping

from bpy.types import Object

from .body_parts import BodyPart
from .body_space import body_space
from .limbs import longest_below
from .names import readings_of

ROLES = ("tail_base", "tail_middle", "tail_tip")
FEWEST_BONES = 3


def chains_of(rig: Object, known: Mapping[BodyPart, tuple[str, ...]]) -> dict[BodyPart, tuple[str, ...]]:
    """The bones of the three parts of a tail. Empty if the body has one by name, or no chain of at least three bones.

    known: the parts that were found before.
    """
    if any((role, "") in known for role in ROLES) or ("pelvis", "") not in known:
        return {}
    readings = readings_of(rig)
    bones = [bone for bone, reading in readings.items() if not reading.control]
    mirrored = body_space(rig, readings, bones).mirrored
    used = {name for chain in known.values() for name in chain}
    above_used = {up for name in used for up in rig.data.bones[name].parent_recursive}

    def is_free(bone) -> bool:
        said = readings[bone]
        return not (bone in mirrored or bone.name in used or bone in above_used or said.other or said.control or said.part)

    pelvis = rig.data.bones[known["pelvis", ""][0]]
    tail = longest_below(pelvis, is_free)
    if len(tail) < FEWEST_BONES:
        return {}
    cuts = [len(tail) * third // len(ROLES) for third in range(len(ROLES) + 1)]
    return {
        (role, ""): tuple(bone.name for bone in tail[start:end])
        for role, start, end in zip(ROLES, cuts, cuts[1:], strict=False)
    }
