# SPDX-License-Identifier: GPL-3.0-or-later
"""Shoulder blades for an animal on four legs whose rig has no bones for them: fixed to the chest, as its rig moves them."""

from collections.abc import Mapping

from .body_parts import SIDES, BodyPart
from .recognition import Recognised
from .segment_axes import Directions
from .segment_lines import SegmentLine

# From the shoulder joint to the upper edge of the blade, in lengths of the upper arm, toward the tail, the middle and
# up. The shoulder blade of dogs, cats and horses is about as long as the humerus and slopes by about 60 degrees.
BACK, UP, INWARD = 0.5, 0.8, 0.3


def added(recognised: Recognised, lines: Mapping[BodyPart, SegmentLine], body: Directions) -> dict[BodyPart, SegmentLine]:
    """The lines, with a shoulder blade on each side that has an upper arm and none."""
    whole = dict(lines)
    chest = lines.get(("chest", ""))
    if chest is None or not body.on_fours:
        return whole
    for side in SIDES:
        if ("upper_arm", side) not in lines or ("shoulder_girdle", side) in lines:
            continue
        arm = lines["upper_arm", side]
        length = (arm.end - arm.start).length
        inward = -body.left if side == "L" else body.left
        top = arm.start + (inward * INWARD - body.forward * BACK - body.belly * UP) * length
        whole["shoulder_girdle", side] = SegmentLine(
            "shoulder_girdle", side, chest.bones[-1:], (top,), top, arm.start.copy()
        )
    return whole
