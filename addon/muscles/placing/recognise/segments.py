# SPDX-License-Identifier: GPL-3.0-or-later
"""Recognition of a body in the bones of a rig, in the rest pose."""

from collections.abc import Mapping

from bpy.types import Object

from ....scene import characters, skinned_bones
from . import digits, recognition, segment_axes, segment_lines, shoulder_blades, skin_ends
from .body import Body
from .body_parts import SIDE_DEFINING_ROLES, SIDES, BodyPart
from .kind import BIRD, FISH, QUADRUPED


def recognise(rig: Object, corrections: Mapping[BodyPart, str] | None = None, kind: str = "") -> Body:
    """The body that a rig moves: by names, by shape, and by the user's corrections of the guess.

    corrections: (role, side) to the first bone of that segment. The side of a central role is "".
    kind: the kind of creature that its bones are looked for as (`kind.KINDS`); "" for a body with arms and legs. Raises
    SinewError as `recognition.recognise` does, and where no part of the limbs is found on both sides, because they
    define left and right on all bodies but a fish's.
    """
    recognised = recognition.recognise(rig, corrections, kind)
    lines = segment_lines.lines_of(rig, recognised)
    has_pair = any(all((role, side) in lines for side in SIDES) for role in SIDE_DEFINING_ROLES)
    if not has_pair and (recognised.left is None or not lines):
        raise Body(rig.name, recognised, {}).missing("thigh", "R" if ("thigh", "L") in lines else "L")
    if kind in (QUADRUPED, BIRD, FISH):
        body = segment_axes.directions_of(lines, recognised.left)
        forward = body.up if kind == FISH else body.forward
        skinned = skinned_bones.skinned_bones(rig, characters.skins_of(rig))
        lines = skin_ends.moved_to_skin(rig, recognised, lines, skinned, forward, body.left)
        if kind == QUADRUPED:
            lines = shoulder_blades.added(recognised, lines, body)
    segments = segment_axes.segments_of(rig, recognised, lines, kind)
    return Body(rig.name, recognised, segments | digits.segments_of(rig, segments))
