# SPDX-License-Identifier: GPL-3.0-or-later
"""Recognition of a body in the bones of a rig, in the rest pose."""

from collections.abc import Mapping

from bpy.types import Object

from . import recognition, segment_axes, segment_lines
from .body import Body
from .body_parts import SIDE_DEFINING_ROLES, SIDES, BodyPart


def recognise(rig: Object, corrections: Mapping[BodyPart, str] | None = None) -> Body:
    """The body that a rig moves: by names, by shape, and by the user's corrections of the guess.

    corrections: (role, side) to the first bone of that segment. The side of a central role is "".
    Raises SinewError as `recognition.recognise` does, and where no part of the
    limbs is found on both sides, because they define left and right.
    """
    recognised = recognition.recognise(rig, corrections)
    lines = segment_lines.lines_of(rig, recognised)
    if not any(all((role, side) in lines for side in SIDES) for role in SIDE_DEFINING_ROLES):
        raise Body(rig.name, recognised, {}).missing("thigh", "R" if ("thigh", "L") in lines else "L")
    return Body(rig.name, recognised, segment_axes.segments_of(rig, recognised, lines))
