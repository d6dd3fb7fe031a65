# SPDX-License-Identifier: GPL-3.0-or-later
"""The digits of a hand: metacarpals and phalanges, from the names of the bones below the hand."""

import re
from collections.abc import Mapping

from bpy.types import Bone, Object
from mathutils import Vector

from ...axes import perpendicular
from . import names
from .body import UPRIGHT, Segment
from .body_parts import DIGITS, MIDDLE, PHALANGES, SIDES, BodyPart
from .segment_lines import SHORTEST_SEGMENT_M

_NUMBERED = re.compile(r"finger[ _.-]?([1-5])", re.IGNORECASE)  # MakeHuman's finger1 is the thumb
_METACARPAL = re.compile(r"metacarp|palm", re.IGNORECASE)
# How much the thumb bends across the palm, against towards it: it is turned by about a right angle (Cooney et al. 1981).
THUMB_ACROSS = 1.0


def segments_of(rig: Object, hands: Mapping[BodyPart, Segment]) -> dict[BodyPart, Segment]:
    """The segments of all digits whose bones are named, for the hands of a body that stands on two legs."""
    readings = None
    found: dict[BodyPart, Segment] = {}
    for side in SIDES:
        hand = hands.get(("hand", side))
        if hand is None or hand.build != UPRIGHT:
            continue
        readings = readings or names.readings_of(rig)
        below = rig.data.bones[hand.bones[0]].children_recursive
        digits = {digit: [] for digit in DIGITS}
        for bone in below:
            digit = _digit_of(bone, readings[bone].part)
            if digit and not _METACARPAL.search(bone.name):
                digits[digit].append(bone)
        across = _across(hand, digits)
        for digit, bones in digits.items():
            for role, line in _lines(digit, bones, hand).items():
                found[role, side] = _segment(role, line, hand, across if digit == "thumb" else None)
    return found


def _digit_of(bone: Bone, part: str) -> str:
    """The digit that a name tells, or ""."""
    if part in DIGITS:
        return part
    numbered = _NUMBERED.search(bone.name)
    return DIGITS[int(numbered[1]) - 1] if numbered else ""


def _lines(digit: str, bones: list[Bone], hand: Segment) -> dict[str, tuple[str, Vector, Vector]]:
    """The bone, start and end of each part of a digit, by role. bones: those of the digit, from the hand outward."""
    bones = sorted(bones, key=lambda bone: len(bone.parent_recursive))
    if not bones:
        return {}
    parts = [part for part in PHALANGES if digit != "thumb" or part != MIDDLE]
    if digit != "thumb":
        parent = bones[0].parent
        own = parent if parent.name not in hand.bones else None
        carrier, start = (own.name, own.head_local) if own else (hand.bones[-1], hand.start)
        lines = [(carrier, start.copy(), bones[0].head_local.copy())]
    else:
        lines = []
    ends = [bone.head_local for bone in bones[1:]] + [bones[-1].tail_local]
    lines += [(bone.name, bone.head_local.copy(), end.copy()) for bone, end in zip(bones, ends, strict=True)]
    named = {f"{digit}_{part}": line for part, line in zip(parts, lines, strict=False)}
    return {role: line for role, line in named.items() if (line[2] - line[1]).length > SHORTEST_SEGMENT_M}


def _across(hand: Segment, digits: Mapping[str, list[Bone]]) -> Vector:
    """The direction from the thumb's side of the hand to the other one, not of unit length."""
    first, last = (
        next((digits[digit][0].head_local for digit in order if digits[digit]), hand.end)
        for order in (("index", "middle"), ("little", "ring"))
    )
    return last - first


def _segment(role: str, line: tuple[str, Vector, Vector], hand: Segment, across: Vector | None) -> Segment:
    bone, start, end = line
    axis = (end - start).normalized()
    palm = hand.front
    if across is not None and across.length > SHORTEST_SEGMENT_M:
        palm = palm + across.normalized() * THUMB_ACROSS
    front = perpendicular(axis, palm, hand.outer)
    return Segment(
        role=role,
        side=hand.side,
        bones=(bone,),
        bone_starts=(0.0,),
        start=start,
        end=end,
        axis=axis,
        front=front,
        outer=front.cross(axis) if hand.side == "L" else axis.cross(front),
        build=hand.build,
    )
