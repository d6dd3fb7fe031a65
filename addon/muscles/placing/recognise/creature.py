# SPDX-License-Identifier: GPL-3.0-or-later
"""Whether a recognised body is a human, for a warning where a preset for humans is added to another creature."""

from collections.abc import Collection

from bpy.types import Object
from mathutils import Vector

from . import names
from .body import Body
from .body_parts import SIDES, TRUNK_ROLES

FIRST_OF_TAIL = "tail_base"
ON_FOUR_LEGS = "it stands on four legs"
NEAR_GROUND = 0.3  # height of a hand above the feet, as a fraction of the height of the legs


def why_not_human(rig: Object, body: Body) -> str:
    """What distinguishes a body from a human, as in "it stands on four legs". Empty for a human."""
    pairs = names.leg_pairs(rig)
    if pairs > 2:
        return f"it has {pairs} pairs of legs"
    arms = [side for side in SIDES if body.has("upper_arm", side)]
    if not arms and names.has_part(rig, "wing"):
        return "it has wings and no arms"
    if names.has_part(rig, "fin"):
        return "it has fins"
    if _arms_reach_ground(body) and (pairs == 2 or _is_horizontal(body)):
        return ON_FOUR_LEGS
    if _is_horizontal(body):
        return "its trunk is horizontal"
    if pairs == 2:
        return "its arms are named as legs"
    return "" if arms else "no arms were found"


def _is_horizontal(body: Body) -> bool:
    return any(segment.on_fours for segment in body.segments.values())


def _arms_reach_ground(body: Body) -> bool:
    """Whether the arms reach down to the height of the feet."""
    legs, arms = (
        [segment for (role, _), segment in body.segments.items() if role in roles]
        for roles in (("thigh", "shin", "foot"), ("upper_arm", "forearm", "hand"))
    )
    if not legs:
        return False
    trunk = next((segment for (role, _), segment in body.segments.items() if role in TRUNK_ROLES and segment.on_fours), None)
    up = -trunk.front if trunk else sum((leg.start - leg.end for leg in legs), Vector()).normalized()
    heights = [point.dot(up) for leg in legs for point in (leg.start, leg.end)]
    lowest_hand = min((arm.end.dot(up) for arm in arms), default=max(heights))
    return lowest_hand < min(heights) + NEAR_GROUND * (max(heights) - min(heights))


def warning(rig: Object, body: Body, preset_name: str, roles: Collection[str]) -> str:
    """The warning about a preset for humans on another creature. Empty where there is nothing to warn about.

    roles: the parts that the preset has tissues on. A preset with a tail is not for a human.
    """
    why = why_not_human(rig, body) if FIRST_OF_TAIL not in roles else ""
    if not why:
        return ""
    instead = "the preset cat, or Add Muscles to Joints" if why == ON_FOUR_LEGS else "Add Muscles to Joints"
    return f"{rig.name} doesn't look like a human: {why}. The preset {preset_name} is for humans; try {instead}"
