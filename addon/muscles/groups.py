# SPDX-License-Identifier: GPL-3.0-or-later
"""Groups of tissues: arms, legs, trunk and head by recognition, or any names that the user gives."""

from ..errors import SinewError
from ..scene import characters
from .placing.recognise import segments
from .placing.recognise.body_parts import TRUNK_ROLES, body_parts

ARM, LEG, TRUNK, HEAD, TAIL = "Arm", "Leg", "Trunk", "Head", "Tail"
_OF_ROLE = {
    **dict.fromkeys(("shoulder_girdle", "upper_arm", "forearm", "hand", "fingers"), ARM),
    **dict.fromkeys(("thigh", "shin", "foot", "toes"), LEG),
    **dict.fromkeys(TRUNK_ROLES, TRUNK),
    **dict.fromkeys(("neck", "head", "jaw"), HEAD),
    **dict.fromkeys(("tail_base", "tail_middle", "tail_tip"), TAIL),
}


def group_of_part(role: str, side: str) -> str:
    """The group of a part of the body: "Arm.L" for ("forearm", "L"), "Trunk" for ("chest", "")."""
    return f"{_OF_ROLE[role]}.{side}" if side else _OF_ROLE[role]


def by_region(rig) -> dict[str, str]:
    """The group of each tissue, by name: that of the bone that it moves. Raises SinewError if no body is recognised."""
    body = segments.recognise(rig)
    of_bone = {
        bone: group_of_part(role, side)
        for role, side in body_parts()
        for bone in body.recognised.chains.get((role, side), ())
    }
    return {tissue.name: _of_tissue(rig, tissue, of_bone) for tissue in characters.tissues_of(rig)}


def _of_tissue(rig, tissue, of_bone: dict[str, str]) -> str:
    settings = tissue.sinew.tissue
    bone = rig.data.bones.get(settings.insertion_bone if settings.kind == "MUSCLE" else settings.origin_bone)
    while bone is not None and bone.name not in of_bone:
        bone = bone.parent
    return of_bone[bone.name] if bone else TRUNK


def members(rig, group: str) -> list:
    """The tissues of a group, sorted by name."""
    return [tissue for tissue in characters.tissues_of(rig) if tissue.sinew.tissue.group == group]


def names(rig) -> list[str]:
    """The names of the groups that tissues belong to, sorted."""
    return sorted({tissue.sinew.tissue.group for tissue in characters.tissues_of(rig)} - {""})


def require_members(rig, group: str) -> list:
    """The tissues of a group. Raises SinewError if there are none."""
    found = members(rig, group)
    if not found:
        raise SinewError(f"{rig.name} has no tissue in the group '{group}'. Group its tissues first (Group by Region)")
    return found
