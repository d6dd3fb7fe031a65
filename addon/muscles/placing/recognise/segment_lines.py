# SPDX-License-Identifier: GPL-3.0-or-later
"""Where each segment of a body starts and ends, from the rest positions of its bones."""

from dataclasses import dataclass

import _sinew
import numpy as np
from bpy.types import Object
from mathutils import Vector

from .body_parts import NEXT_ROLE, SIDES, TRUNK_ROLES, BodyPart
from .recognition import Recognised

SHORTEST_SEGMENT_M = 1e-5
# Where the pelvis and the abdomen end, as fractions of the path from the hips to the neck. The number of spine bones varies.
TRUNK_ENDS = (0.2, 0.48)


@dataclass(frozen=True)
class SegmentLine:
    """A segment without its front and outer axes. heads: the rest heads of its bones. Points are metres, armature space."""

    role: str
    side: str
    bones: tuple[str, ...]
    heads: tuple[Vector, ...]
    start: Vector
    end: Vector

    @property
    def axis(self) -> Vector:
        """The unit vector from start to end."""
        return (self.end - self.start).normalized()


def lines_of(rig: Object, recognised: Recognised) -> dict[BodyPart, SegmentLine]:
    """The line of each recognised body part. Parts without length are left out."""
    lines = {} if recognised.lines else _trunk_lines(rig, recognised)
    for part, bones in recognised.chains.items():
        if part in recognised.lines:
            heads, start, end = recognised.lines[part]
            lines[part] = SegmentLine(*part, bones, heads, start, end)
        elif part[0] not in TRUNK_ROLES:
            lines[part] = _line(rig, recognised, part)
    return {part: line for part, line in lines.items() if (line.end - line.start).length >= SHORTEST_SEGMENT_M}


def _line(rig: Object, recognised: Recognised, part: BodyPart) -> SegmentLine:
    role, side = part
    bones = [rig.data.bones[name] for name in recognised.chains[part]]
    landmarks = recognised.ends.get(part) or recognised.chains.get((NEXT_ROLE.get(role, ""), side), ())[:1]
    ends = [rig.data.bones[name].head_local for name in landmarks] or [bones[-1].tail_local]
    return SegmentLine(
        role=role,
        side=side,
        bones=tuple(bone.name for bone in bones),
        heads=tuple(bone.head_local.copy() for bone in bones),
        start=bones[0].head_local.copy(),
        end=sum(ends, Vector()) / len(ends),
    )


def _trunk_lines(rig: Object, recognised: Recognised) -> dict[BodyPart, SegmentLine]:
    """Pelvis, abdomen and chest at fixed fractions of the path from the hips along the spine to the neck.

    The position of the root bone and the number of spine bones vary between rigs. Hips and neck have anatomical positions.
    """
    chains = recognised.chains
    spine = [rig.data.bones[name] for role in TRUNK_ROLES for name in chains.get((role, ""), ())]
    if not spine:
        return {}
    thighs = [chains.get(("thigh", side)) for side in SIDES]
    if all(thighs):
        hips = sum((rig.data.bones[thigh[0]].head_local for thigh in thighs), Vector()) / 2
    else:
        hips = spine[0].head_local.copy()
    above = chains.get(("neck", "")) or chains.get(("head", ""))
    top = rig.data.bones[above[0]].head_local if above else spine[-1].tail_local
    joints = [hips, *(bone.head_local for bone in spine[1:]), top]
    up = (top - hips).normalized()
    path = [hips]
    for joint in joints[1:]:
        if (joint - path[-1]).dot(up) > SHORTEST_SEGMENT_M:  # skips bones that start below the hips
            path.append(joint)
    polyline = _sinew.Path(np.array(path, np.float64))
    cuts = [Vector(polyline.at(fraction * polyline.length)) for fraction in (0.0, *TRUNK_ENDS, 1.0)]
    lines = {}
    for role, start, end in zip(TRUNK_ROLES, cuts, cuts[1:], strict=False):
        bones = _spine_bones_between(spine, start, end, up) if role != "pelvis" else spine[:1]
        lines[role, ""] = SegmentLine(
            role=role,
            side="",
            bones=tuple(bone.name for bone in bones),
            heads=tuple(bone.head_local.copy() for bone in bones),
            start=start,
            end=end,
        )
    return lines


def _spine_bones_between(spine: list, start: Vector, end: Vector, up: Vector) -> list:
    """The spine bones that carry a section of the trunk: the bone that the section starts in, and those that start in it."""
    heights = [bone.head_local.dot(up) for bone in spine]
    first = max((i for i, height in enumerate(heights) if height <= start.dot(up) + SHORTEST_SEGMENT_M), default=0)
    return [bone for i, bone in enumerate(spine) if i == first or start.dot(up) < heights[i] < end.dot(up)]
