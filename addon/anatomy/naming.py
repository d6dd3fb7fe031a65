# SPDX-License-Identifier: GPL-3.0-or-later
"""What rigs call their bones: a table, so that another kind of rig is another entry here and no code.

A role's `bones` run from the body outward; split bones stand one after the other and count as one segment. The
segment ends at the mean of the heads of `ends` (as far as the rig has them), else at the tail of its last bone.
"{side}" stands for the scheme's own word for left or right, wherever it stands in a name.
"""

from collections.abc import Mapping
from dataclasses import dataclass

CENTRAL_ROLES = ("pelvis", "chest")
SIDED_ROLES = ("shoulder_girdle", "upper_arm", "forearm", "hand", "thigh", "shin", "foot")
ROLES = CENTRAL_ROLES + SIDED_ROLES
SIDES = ("L", "R")


@dataclass(frozen=True)
class Chain:
    """The bones of one role. `thumb_side` and `little_side` are a hand's landmarks: bones at its two edges."""

    bones: tuple[str, ...]
    ends: tuple[str, ...] = ()
    thumb_side: str = ""
    little_side: str = ""


@dataclass(frozen=True)
class Scheme:
    """How one kind of rig names its bones."""

    label: str
    sides: Mapping[str, str]
    chains: Mapping[str, Chain]


SCHEMES = (
    Scheme(
        label="MakeHuman default",
        sides={"L": ".L", "R": ".R"},
        chains={
            "pelvis": Chain(("root",), ends=("spine04",)),
            "chest": Chain(("spine02", "spine01")),
            "shoulder_girdle": Chain(("clavicle{side}", "shoulder01{side}")),
            "upper_arm": Chain(("upperarm01{side}", "upperarm02{side}")),
            "forearm": Chain(("lowerarm01{side}", "lowerarm02{side}")),
            "hand": Chain(
                ("wrist{side}",),
                ends=("finger2-1{side}", "finger3-1{side}", "finger4-1{side}", "finger5-1{side}"),
                thumb_side="finger2-1{side}",
                little_side="finger5-1{side}",
            ),
            "thigh": Chain(("upperleg01{side}", "upperleg02{side}")),
            "shin": Chain(("lowerleg01{side}", "lowerleg02{side}")),
            "foot": Chain(
                ("foot{side}",),
                ends=("toe1-1{side}", "toe2-1{side}", "toe3-1{side}", "toe4-1{side}", "toe5-1{side}"),
            ),
        },
    ),
    Scheme(
        label="Rigify human metarig",
        sides={"L": ".L", "R": ".R"},
        chains={
            "pelvis": Chain(("spine",), ends=("spine.001",)),
            "chest": Chain(("spine.002", "spine.003")),
            "shoulder_girdle": Chain(("shoulder{side}",)),
            "upper_arm": Chain(("upper_arm{side}",)),
            "forearm": Chain(("forearm{side}",)),
            "hand": Chain(
                ("hand{side}",),
                ends=("f_index.01{side}", "f_middle.01{side}", "f_ring.01{side}", "f_pinky.01{side}"),
                thumb_side="f_index.01{side}",
                little_side="f_pinky.01{side}",
            ),
            "thigh": Chain(("thigh{side}",)),
            "shin": Chain(("shin{side}",)),
            "foot": Chain(("foot{side}",), ends=("toe{side}",)),
        },
    ),
)
