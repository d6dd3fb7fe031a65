# SPDX-License-Identifier: GPL-3.0-or-later
"""Where the outermost segments of an animal end: head, forepaw, hind paw and their toes, from the skin that they carry.

Nothing follows these bones in a rig, so their own tails tell little: a head's tail can point up or be a tenth of the
head long.
"""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
from bpy.types import Object
from mathutils import Vector

from ....scene.skinned_bones import SkinnedBones
from .body_parts import NEXT_ROLE, BodyPart
from .recognition import Recognised
from .segment_lines import SHORTEST_SEGMENT_M, SegmentLine

FARTHEST = 0.05  # fraction of a segment's points whose mean is its end
FEWEST_POINTS = 4
HEADWARD_COSINE = (
    0.35  # of the angle between the body's front and a point of the head, seen from the nape: ears point elsewhere
)
AT_ENDS = ("head", "hand", "fingers", "foot", "toes")


def moved_to_skin(
    rig: Object,
    recognised: Recognised,
    lines: Mapping[BodyPart, SegmentLine],
    skinned: SkinnedBones,
    forward: Vector,
    left: Vector,
) -> dict[BodyPart, SegmentLine]:
    """The lines, with those of the last parts of limbs and of the head ending at the skin. forward, left: unit vectors."""
    moved = dict(lines)
    for part, line in lines.items():
        role, side = part
        if role in AT_ENDS and (NEXT_ROLE.get(role, ""), side) not in lines:
            end = _end(rig, recognised, line, skinned, forward, left)
            if end is not None:
                moved[part] = replace(line, end=end)
    return moved


def _end(
    rig: Object, recognised: Recognised, line: SegmentLine, skinned: SkinnedBones, forward: Vector, left: Vector
) -> Vector | None:
    """The mean of the points farthest from the start. None where too few points are known."""
    others = {name for part, names in recognised.chains.items() if part != (line.role, line.side) for name in names}
    first = rig.data.bones[line.bones[0]]
    below = {bone.name for bone in (first, *first.children_recursive)} - others
    offsets = skinned.points_of(below) - np.array(line.start)
    distances = np.linalg.norm(offsets, axis=1)
    if line.role == "head":
        ahead = offsets @ np.array(forward) > HEADWARD_COSINE * distances
        offsets, distances = offsets[ahead], distances[ahead]
    if len(offsets) < FEWEST_POINTS:
        return None
    count = max(int(FARTHEST * len(offsets)), 3)
    offset = Vector(offsets[np.argsort(distances, kind="stable")[-count:]].mean(axis=0))
    if line.role == "head":
        offset -= left * offset.dot(left)
    return line.start + offset if offset.length > SHORTEST_SEGMENT_M else None
