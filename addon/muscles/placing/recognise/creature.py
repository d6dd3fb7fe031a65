# SPDX-License-Identifier: GPL-3.0-or-later
"""The warning where a preset is added to a creature of another kind."""

from bpy.types import Object
from mathutils import Vector

from . import names
from .body import Body
from .body_parts import SIDES, TRUNK_ROLES
from .choice import proposal
from .kind import ARTHROPOD, BIRD, FISH, HUMAN, LABELS, OTHER, QUADRUPED, Kind

SURE = 0.8  # how sure the kind of a creature must be for a warning about a preset
PLURALS = {
    HUMAN: "humans",
    QUADRUPED: "animals on four legs",
    BIRD: "birds",
    FISH: "fish",
    ARTHROPOD: "insects and spiders",
    OTHER: "other creatures",
}
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


def warning(rig: Object, body: Body, preset_name: str, creature: str, found: Kind) -> str:
    """The warning about a preset on a creature of another kind. Empty where there is nothing to warn about.

    creature: the kind that the preset is for; "" for any. found: the kind of the rig.
    """
    other = found.name != creature and found.sureness >= SURE
    why = why_not_human(rig, body) if creature == HUMAN else ""
    if not why and other:
        why = f"it looks like {LABELS[found.name]}"
    if not creature or not why:
        return ""
    label = LABELS[creature]
    instead = proposal(QUADRUPED if why == ON_FOUR_LEGS else found.name if found.name != creature else OTHER)
    return f"{rig.name} doesn't look like {label}: {why}. The preset {preset_name} is for {PLURALS[creature]}; try {instead}"
