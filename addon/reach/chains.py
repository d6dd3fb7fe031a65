# SPDX-License-Identifier: GPL-3.0-or-later
"""Which bones take part in a reach: a chain from a bone up, by default to the pelvis, as the thesis has its four."""

from ..errors import SinewError
from ..muscles.placing.recognise import recognition

ENDS = (("hand", "L"), ("hand", "R"), ("foot", "L"), ("foot", "R"))


def chain_of(rig, bone: str, length: int = 0) -> list[str]:
    """The bones of a chain that ends with `bone`, from the body outward.

    length: how many bones; 0: up to the pelvis, which stays, or where the rig has none that Sinew knows up to its root,
    which stays unless it is all there is. Raises SinewError where there is no such bone.
    """
    if bone not in rig.pose.bones:
        raise SinewError(f"{rig.name} has no bone '{bone}': choose one of its bones in Pose Mode")
    upward = [rig.pose.bones[bone], *rig.pose.bones[bone].parent_recursive]
    names = [found.name for found in upward]
    if length > 0:
        return names[:length][::-1]
    pelvis = _pelvis(rig)
    below = next((place for place, name in enumerate(names) if name in pelvis), len(names) - 1)
    return names[: max(below, 1)][::-1]


def ends_of(rig) -> dict[tuple[str, str], str]:
    """The bones of hands and feet, by (role, side), of a rig that Sinew recognises."""
    found = _recognised(rig)
    return {end: found.chains[end][-1] for end in ENDS if found and end in found.chains}


def together(rig, chains: list[list[str]]) -> list[str]:
    """The bones of several chains, each once, parents before children."""
    wanted = {name for chain in chains for name in chain}
    return [bone.name for bone in rig.pose.bones if bone.name in wanted]


def _pelvis(rig) -> tuple[str, ...]:
    found = _recognised(rig)
    return found.chains.get(("pelvis", ""), ()) if found else ()


def _recognised(rig):
    try:
        return recognition.recognise(rig)
    except SinewError:
        return None  # most rigs are no human; their bones are chains all the same
