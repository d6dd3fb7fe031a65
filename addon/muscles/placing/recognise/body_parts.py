# SPDX-License-Identifier: GPL-3.0-or-later
"""The parts of a body that Sinew knows: their roles, their sides, and which part follows which.

A body part is a role and a side: ("upper_arm", "L"). The side of a central role is "".
"""

BodyPart = tuple[str, str]

TRUNK_ROLES = ("pelvis", "abdomen", "chest")
CENTRAL_ROLES = (*TRUNK_ROLES, "neck", "head", "jaw", "tail_base", "tail_middle", "tail_tip")
SIDED_ROLES = (
    "shoulder_girdle",
    "upper_arm",
    "forearm",
    "hand",
    "fingers",
    "thigh",
    "shin",
    "foot",
    "toes",
)
ROLES = CENTRAL_ROLES + SIDED_ROLES
# The parts of the digits of a hand: the thumb has no middle phalanx. They follow from the hand and its fingers' bones.
DIGITS = ("thumb", "index", "middle", "ring", "little")
METACARPAL, PROXIMAL, MIDDLE, DISTAL = PHALANGES = ("metacarpal", "proximal", "middle", "distal")
DIGIT_ROLES = tuple(f"{digit}_{part}" for digit in DIGITS for part in PHALANGES if not (digit == "thumb" and part == MIDDLE))
# Parts that a complete body may lack. A body that lacks another part is looked at more closely: by the words of its names.
OPTIONAL_ROLES = frozenset({"jaw", "tail_base", "tail_middle", "tail_tip", "fingers", "toes"})
SIDES = ("L", "R")
# Parts that define left and right, best first. A body has one of them on both sides.
SIDE_DEFINING_ROLES = ("thigh", "upper_arm", "shoulder_girdle", "forearm")
# A segment ends where the next one begins, because the tails of imported bones point in any direction.
NEXT_ROLE = {
    "shoulder_girdle": "upper_arm",
    "upper_arm": "forearm",
    "forearm": "hand",
    "hand": "fingers",
    "thigh": "shin",
    "shin": "foot",
    "foot": "toes",
    "neck": "head",
    "tail_base": "tail_middle",
    "tail_middle": "tail_tip",
}


def body_parts() -> list[BodyPart]:
    """All body parts, central ones first."""
    return [(role, "") for role in CENTRAL_ROLES] + [(role, side) for role in SIDED_ROLES for side in SIDES]


def part_label(role: str, side: str = "") -> str:
    """A body part for the user: "upper arm L" for ("upper_arm", "L")."""
    return f"{role.replace('_', ' ')} {side}".strip()
