# SPDX-License-Identifier: GPL-3.0-or-later
"""How reluctant a joint is that also moves other limbs, as a joint of the spine moves the head and the other arm.

A hand to the face then bends the arm, and the spine only as far as the arm does not reach. The law knows no names of bones,
and a chain without branches is not changed by it.
"""

import numpy as np

# Of bodies of the same form, the mass grows as the cube of the length.
_MASS_EXPONENT = 3
# Of the fraction of the limb. Measured on a body with Unreal's bone names, a hand to the head: with 1, the three joints of
# the spine rotate by 61 degrees and the elbow by 55; with 2, by 20 and 102.
_EXPONENT = 2


def factors(rig, names: list[str]) -> np.ndarray:
    """(joints,) float64, 0..1: a factor on the eagerness of each joint of an IK chain.

    It is the square of the fraction that the limb is of all that the joint moves, by mass. The limb is the chain and what
    moves with its ends. names: the bones of the chain, parents before children.
    """
    chain = set(names)
    ends = chain - {bone.parent.name for bone in map(rig.pose.bones.get, names) if bone.parent}
    limb, moved = ({name: _mass(rig.pose.bones[name]) for name in names} for _ in range(2))
    for bone in rig.pose.bones:
        carrier = bone
        while carrier is not None and carrier.name not in chain:
            carrier = carrier.parent
        if carrier is not None and carrier != bone:
            moved[carrier.name] += _mass(bone)
            limb[carrier.name] += _mass(bone) if carrier.name in ends else 0.0
    for name in reversed(names):
        parent = rig.pose.bones[name].parent
        if parent is not None and parent.name in chain:
            limb[parent.name] += limb[name]
            moved[parent.name] += moved[name]
    return np.array([(limb[name] / moved[name]) ** _EXPONENT if limb[name] > 0.0 else 1.0 for name in names])


def _mass(bone) -> float:
    """The mass of a bone's part of the body at rest, in an arbitrary unit. A bone that moves no skin has none."""
    return bone.bone.length**_MASS_EXPONENT if bone.bone.use_deform else 0.0
