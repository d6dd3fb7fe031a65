# SPDX-License-Identifier: GPL-3.0-or-later
"""The bone names of the kinds of rig that Sinew knows, as a table: a new kind of rig is a new entry and no code.

The bones of a role run from the body outward. Split and twist bones follow the bone that they belong to and form one segment
with it. A "?" after a name marks a bone that a rig may lack. "{side}" is replaced by the scheme's word for left or right.
Names are compared without their namespace ("mixamorig:") and without case.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace


@dataclass(frozen=True)
class Scheme:
    """The bone names of one kind of rig.

    label: the kind of rig, for the user. sides: the scheme's word for "L" and "R". chains: the bones of each role. ends: the
    bones whose mean head position is the end of a role's segment, where the next role does not define it. edges: two
    bones of the hand, one at the side of the thumb and one at the side of the little finger.
    """

    label: str
    sides: Mapping[str, str]
    chains: Mapping[str, tuple[str, ...]]
    ends: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    edges: tuple[str, str] = ("", "")


def sided(scheme: Scheme, name: str, side: str) -> str:
    """The bone name of a side, from a name of the table."""
    return name.rstrip("?").replace("{side}", scheme.sides.get(side, ""))


def _finger_ends(*names: str) -> dict[str, tuple[str, ...]]:
    return {"hand": names}


def _generated(scheme: Scheme) -> Scheme:
    """The deform bones that Rigify generates from a metarig. Rigify splits its limbs into two bones."""
    split = {"upper_arm", "forearm", "thigh", "shin"}

    def bones(role: str, names: tuple[str, ...]) -> tuple[str, ...]:
        deform = tuple(f"DEF-{name}" for name in names)
        return (*deform, f"{deform[-1]}.001?") if role in split else deform

    return replace(
        scheme,
        label=f"{scheme.label}, generated",
        chains={role: bones(role, names) for role, names in scheme.chains.items()},
        ends={role: tuple(f"DEF-{name}" for name in names) for role, names in scheme.ends.items()},
        edges=tuple(f"DEF-{name}" for name in scheme.edges),
    )


_MAKEHUMAN = Scheme(
    label="MakeHuman default",
    sides={"L": ".L", "R": ".R"},
    chains={
        "pelvis": ("root", "spine05"),
        "abdomen": ("spine04", "spine03"),
        "chest": ("spine02", "spine01"),
        "neck": ("neck01", "neck02?", "neck03?"),
        "head": ("head",),
        "jaw": ("jaw",),
        "shoulder_girdle": ("clavicle{side}", "shoulder01{side}"),
        "upper_arm": ("upperarm01{side}", "upperarm02{side}"),
        "forearm": ("lowerarm01{side}", "lowerarm02{side}"),
        "hand": ("wrist{side}",),
        "fingers": ("finger3-1{side}",),
        "thigh": ("upperleg01{side}", "upperleg02{side}"),
        "shin": ("lowerleg01{side}", "lowerleg02{side}"),
        "foot": ("foot{side}",),
        "toes": ("toe1-1{side}",),
    },
    ends={
        "hand": ("finger2-1{side}", "finger3-1{side}", "finger4-1{side}", "finger5-1{side}"),
        "foot": ("toe1-1{side}", "toe2-1{side}", "toe3-1{side}", "toe4-1{side}", "toe5-1{side}"),
    },
    edges=("finger2-1{side}", "finger5-1{side}"),
)

_RIGIFY_HUMAN = Scheme(
    label="Rigify human",
    sides={"L": ".L", "R": ".R"},
    chains={
        "pelvis": ("spine",),
        "abdomen": ("spine.001",),
        "chest": ("spine.002", "spine.003"),
        "neck": ("spine.004", "spine.005?"),
        "head": ("spine.006",),
        "jaw": ("jaw",),
        "shoulder_girdle": ("shoulder{side}",),
        "upper_arm": ("upper_arm{side}",),
        "forearm": ("forearm{side}",),
        "hand": ("hand{side}",),
        "fingers": ("f_middle.01{side}",),
        "thigh": ("thigh{side}",),
        "shin": ("shin{side}",),
        "foot": ("foot{side}",),
        "toes": ("toe{side}",),
    },
    ends=_finger_ends("f_index.01{side}", "f_middle.01{side}", "f_ring.01{side}", "f_pinky.01{side}"),
    edges=("f_index.01{side}", "f_pinky.01{side}"),
)

_RIGIFY_CAT = Scheme(
    label="Rigify cat",
    sides={"L": ".L", "R": ".R"},
    chains={
        "pelvis": ("spine",),
        "abdomen": ("spine.001", "spine.002"),
        "chest": ("spine.003",),
        "neck": ("spine.004", "spine.005?"),
        "head": ("spine.006",),
        "jaw": ("jaw",),
        "tail_base": ("tail.001",),
        "tail_middle": ("tail.002",),
        "tail_tip": ("tail.003", "tail.004?"),
        "shoulder_girdle": ("shoulder{side}",),
        "upper_arm": ("upper_arm{side}",),
        "forearm": ("forearm{side}",),
        "hand": ("hand{side}",),
        "fingers": ("f_toe{side}",),
        "thigh": ("thigh{side}",),
        "shin": ("shin{side}",),
        "foot": ("foot{side}",),
        "toes": ("r_toe{side}",),
    },
    edges=("f_index.001{side}", "f_pinky.001{side}"),
)

_RIGIFY_WOLF = Scheme(
    label="Rigify wolf",
    sides={"L": ".L", "R": ".R"},
    chains={
        "pelvis": ("spine.004",),
        "abdomen": ("spine.005", "spine.006"),
        "chest": ("spine.007", "spine.008"),
        "neck": ("spine.009", "spine.010?"),
        "head": ("spine.011",),
        "jaw": ("jaw",),
        "tail_base": ("spine.003",),
        "tail_middle": ("spine.002",),
        "tail_tip": ("spine.001", "spine?"),
        "shoulder_girdle": ("shoulder{side}",),
        "upper_arm": ("front_thigh{side}",),
        "forearm": ("front_shin{side}",),
        "hand": ("front_foot{side}",),
        "fingers": ("front_toe{side}",),
        "thigh": ("thigh{side}",),
        "shin": ("shin{side}",),
        "foot": ("foot{side}",),
        "toes": ("toe{side}",),
    },
    edges=("f_index.01{side}", "f_pinky.01{side}"),
)

_RIGIFY_HORSE = Scheme(
    label="Rigify horse",
    sides={"L": ".L", "R": ".R"},
    chains={
        "pelvis": ("spine.001",),
        "abdomen": ("spine.002", "spine.003"),
        "chest": ("spine.004", "spine.005", "spine.006"),
        "neck": ("neck.001", "neck.002", "neck.003", "neck.004"),
        "head": ("head",),
        "jaw": ("jaw",),
        "tail_base": ("tail.001", "tail.002"),
        "tail_middle": ("tail.003",),
        "tail_tip": ("tail.004", "tail.005?"),
        "shoulder_girdle": ("shoulder{side}",),
        "upper_arm": ("upper_arm{side}",),
        "forearm": ("forearm{side}",),
        "hand": ("forefoot{side}",),
        "fingers": ("f_toe{side}",),
        "thigh": ("thigh{side}",),
        "shin": ("lower_leg{side}",),
        "foot": ("hind_foot{side}",),
        "toes": ("r_toe{side}",),
    },
)

_MIXAMO = Scheme(
    label="Mixamo",
    sides={"L": "Left", "R": "Right"},
    chains={
        "pelvis": ("Hips",),
        "abdomen": ("Spine",),
        "chest": ("Spine1", "Spine2?", "Spine3?"),
        "neck": ("Neck", "Neck1?"),
        "head": ("Head",),
        "jaw": ("Jaw",),
        "shoulder_girdle": ("{side}Shoulder",),
        "upper_arm": ("{side}Arm",),
        "forearm": ("{side}ForeArm",),
        "hand": ("{side}Hand",),
        "fingers": ("{side}HandMiddle1",),
        "thigh": ("{side}UpLeg",),
        "shin": ("{side}Leg",),
        "foot": ("{side}Foot",),
        "toes": ("{side}ToeBase",),
    },
    ends=_finger_ends("{side}HandIndex1", "{side}HandMiddle1", "{side}HandRing1", "{side}HandPinky1")
    | {"head": ("HeadTop_End",), "toes": ("{side}Toe_End",)},
    edges=("{side}HandIndex1", "{side}HandPinky1"),
)

_UNREAL = Scheme(
    label="Unreal mannequin",
    sides={"L": "_l", "R": "_r"},
    chains={
        "pelvis": ("pelvis",),
        "abdomen": ("spine_01",),
        "chest": ("spine_02", "spine_03?", "spine_04?", "spine_05?"),
        "neck": ("neck_01", "neck_02?"),
        "head": ("head",),
        "jaw": ("jaw",),
        "shoulder_girdle": ("clavicle{side}",),
        "upper_arm": ("upperarm{side}", "upperarm_twist_01{side}?", "upperarm_twist_02{side}?"),
        "forearm": ("lowerarm{side}", "lowerarm_twist_02{side}?", "lowerarm_twist_01{side}?"),
        "hand": ("hand{side}",),
        "fingers": ("middle_01{side}",),
        "thigh": ("thigh{side}", "thigh_twist_01{side}?", "thigh_twist_02{side}?"),
        "shin": ("calf{side}", "calf_twist_02{side}?", "calf_twist_01{side}?"),
        "foot": ("foot{side}",),
        "toes": ("ball{side}",),
    },
    ends=_finger_ends("index_01{side}", "middle_01{side}", "ring_01{side}", "pinky_01{side}"),
    edges=("index_01{side}", "pinky_01{side}"),
)

_VROID = Scheme(
    label="VRM (VRoid)",
    sides={"L": "_L_", "R": "_R_"},
    chains={
        "pelvis": ("J_Bip_C_Hips",),
        "abdomen": ("J_Bip_C_Spine",),
        "chest": ("J_Bip_C_Chest", "J_Bip_C_UpperChest?"),
        "neck": ("J_Bip_C_Neck",),
        "head": ("J_Bip_C_Head",),
        "jaw": ("J_Bip_C_Jaw",),
        "shoulder_girdle": ("J_Bip{side}Shoulder",),
        "upper_arm": ("J_Bip{side}UpperArm",),
        "forearm": ("J_Bip{side}LowerArm",),
        "hand": ("J_Bip{side}Hand",),
        "fingers": ("J_Bip{side}Middle1",),
        "thigh": ("J_Bip{side}UpperLeg",),
        "shin": ("J_Bip{side}LowerLeg",),
        "foot": ("J_Bip{side}Foot",),
        "toes": ("J_Bip{side}ToeBase",),
    },
    ends=_finger_ends("J_Bip{side}Index1", "J_Bip{side}Middle1", "J_Bip{side}Ring1", "J_Bip{side}Little1"),
    edges=("J_Bip{side}Index1", "J_Bip{side}Little1"),
)

_VRM_HUMANOID = Scheme(
    label="VRM humanoid",
    sides={"L": "left", "R": "right"},
    chains={
        "pelvis": ("hips",),
        "abdomen": ("spine",),
        "chest": ("chest", "upperChest?"),
        "neck": ("neck",),
        "head": ("head",),
        "jaw": ("jaw",),
        "shoulder_girdle": ("{side}Shoulder",),
        "upper_arm": ("{side}UpperArm",),
        "forearm": ("{side}LowerArm",),
        "hand": ("{side}Hand",),
        "fingers": ("{side}MiddleProximal",),
        "thigh": ("{side}UpperLeg",),
        "shin": ("{side}LowerLeg",),
        "foot": ("{side}Foot",),
        "toes": ("{side}Toes",),
    },
    ends=_finger_ends("{side}IndexProximal", "{side}MiddleProximal", "{side}RingProximal", "{side}LittleProximal"),
    edges=("{side}IndexProximal", "{side}LittleProximal"),
)

SCHEMES = (
    _MAKEHUMAN,
    _RIGIFY_HUMAN,
    _RIGIFY_CAT,
    _RIGIFY_WOLF,
    _RIGIFY_HORSE,
    _generated(_RIGIFY_HUMAN),
    _generated(_RIGIFY_CAT),
    _MIXAMO,
    _UNREAL,
    _VROID,
    _VRM_HUMANOID,
)
