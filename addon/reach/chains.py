# SPDX-License-Identifier: GPL-3.0-or-later
"""The bones that take part in a reach: a chain from a bone up, by default to the pelvis (Arabaci 2001, four chains)."""

from collections.abc import Mapping

from ..errors import SinewError
from ..muscles.placing.recognise import recognition
from ..muscles.placing.recognise.body_parts import BodyPart

ENDS = (("hand", "L"), ("hand", "R"), ("foot", "L"), ("foot", "R"))


def chain_of(rig, bone: str, length: int = 0) -> list[str]:
    """The names of the bones of a chain that ends with `bone`, from the body outward.

    length: the number of bones. 0: all bones below the pelvis, or below the root on a rig that Sinew does not recognise; a
    chain of the root alone consists of the root. Raises SinewError if there is no such bone.
    """
    if bone not in rig.pose.bones:
        raise SinewError(f"{rig.name} has no bone '{bone}': choose one of its bones in Pose Mode")
    upward = [rig.pose.bones[bone], *rig.pose.bones[bone].parent_recursive]
    names = [each.name for each in upward]
    if length > 0:
        return names[:length][::-1]
    pelvis = _pelvis(rig)
    below = next((index for index, name in enumerate(names) if name in pelvis), len(names) - 1)
    return names[: max(below, 1)][::-1]


def ends_of(rig) -> dict[tuple[str, str], str]:
    """The names of the bones of hands and feet by (role, side). Empty for a rig that Sinew does not recognise."""
    chains = _chains(rig)
    return {end: chains[end][-1] for end in ENDS if end in chains}


def union(rig, chains: list[list[str]]) -> list[str]:
    """The names of the bones of several chains, each once, parents before children."""
    names = {name for chain in chains for name in chain}
    return [bone.name for bone in rig.pose.bones if bone.name in names]


def _pelvis(rig) -> tuple[str, ...]:
    return _chains(rig).get(("pelvis", ""), ())


def _chains(rig) -> Mapping[BodyPart, tuple[str, ...]]:
    try:
        return recognition.recognise(rig).chains
    except SinewError:
        return {}  # not an error here: a chain of a rig that is not recognised ends at its root
