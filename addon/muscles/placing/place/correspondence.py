# SPDX-License-Identifier: GPL-3.0-or-later
"""Carries tissues from one body to another by matched skins (docs/mathematics/fitting.md, Transfer).

A point corresponds to the point of the same segment at the same fraction of its length, in the same direction around it,
and at the same fraction of the ray to the skin. So a muscle that was tuned on one character keeps its place between bone and
skin on another, whatever their proportions.
"""

from dataclasses import dataclass, replace

from mathutils import Vector

from ....errors import SinewError
from ....scene.tissue_empty import TissueShape
from ...transfer import spanned
from ..fit.skin_surface import SkinSurface
from ..recognise.body import Body, Segment
from .placement import radius, with_existing_wraps

SHORTEST_M = 1e-6


@dataclass(frozen=True)
class SkinnedBody:
    """A body and its skin in the rest pose; without a skin, its usual proportions count."""

    body: Body
    skin: SkinSurface | None


def carried(
    shapes: list[TissueShape], source: SkinnedBody, target: SkinnedBody, problems: dict[str, str]
) -> list[TissueShape]:
    """The tissues of one body on another. problems: gets a message for each that has no counterpart there."""
    carried_shapes = []
    for shape in shapes:
        try:
            carried_shapes.append(_carried(shape, source, target))
        except SinewError as error:
            problems[shape.name] = str(error)
    return with_existing_wraps(carried_shapes)


def _carried(shape: TissueShape, source: SkinnedBody, target: SkinnedBody) -> TissueShape:
    pair = _Pair(shape, source, target)
    if shape.kind == "SPHERE":
        centre, bone = pair.point(shape.centre, shape.origin_bone)
        semi_axes = shape.semi_axes * pair.width_scale()
        return replace(shape, centre=centre, semi_axes=semi_axes, origin_bone=bone, insertion_bone=bone)
    origin, origin_bone = pair.point(shape.origin, shape.origin_bone)
    insertion, insertion_bone = pair.point(shape.insertion, shape.insertion_bone)
    if (insertion - origin).length < SHORTEST_M:
        raise SinewError(f"{shape.name}: its ends are at the same point of {target.body.rig_name}")
    length_scale = (insertion - origin).length / (shape.insertion - shape.origin).length
    width_scale = pair.width_scale()
    centre = pair.point(shape.centre, shape.origin_bone)[0]
    aside = pair.point(shape.centre + shape.rotation @ Vector((shape.semi_axes.x, 0, 0)), shape.origin_bone)[0]
    return spanned(
        origin,
        insertion,
        x_like=aside - centre,
        widths=(shape.semi_axes.x * width_scale, shape.semi_axes.y * width_scale),
        origin_tendon=shape.origin_tendon * length_scale,
        insertion_tendon=shape.insertion_tendon * length_scale,
        name=shape.name,
        kind=shape.kind,
        origin_bone=origin_bone,
        insertion_bone=insertion_bone if shape.kind == "MUSCLE" else origin_bone,
        volume_keeping=shape.volume_keeping,
        via_points=tuple(pair.point(point, bone)[::-1] for bone, point in shape.via_points),
        wraps=shape.wraps,
        skin_thickness=shape.skin_thickness * width_scale,
    )


class _Pair:
    """The corresponding segments of two bodies, for the points of one tissue."""

    def __init__(self, shape: TissueShape, source: SkinnedBody, target: SkinnedBody):
        self._shape, self._source, self._target = shape, source, target

    def point(self, point: Vector, bone: str) -> tuple[Vector, str]:
        """The corresponding point, and the bone that carries it."""
        here, there = self._segments(bone)
        along = here.along(point)
        axis_point = here.point(along)
        across = point - axis_point
        if across.length < SHORTEST_M:
            return there.point(along), there.bone_at(along)
        ahead, outward = across.dot(here.front) / across.length, across.dot(here.outer) / across.length
        direction = (there.front * ahead + there.outer * outward).normalized()
        depth = across.length / radius(here, axis_point, across.normalized(), self._source.skin)
        start = there.point(along)
        return start + direction * (depth * radius(there, start, direction, self._target.skin)), there.bone_at(along)

    def width_scale(self) -> float:
        """The radius of the target's segment at the belly over that of the source's."""
        here, there = self._segments(self._shape.origin_bone)
        along = min(max(here.along(self._shape.centre), 0.0), 1.0)

        def mean_radius(segment: Segment, skin: SkinSurface | None) -> float:
            return sum(radius(segment, segment.point(along), segment.direction(angle), skin) for angle in (0, 90, 180, 270))

        return mean_radius(there, self._target.skin) / mean_radius(here, self._source.skin)

    def _segments(self, bone: str) -> tuple[Segment, Segment]:
        for (role, side), segment in self._source.body.segments.items():
            if bone in segment.bones:
                if not self._target.body.has(role, side):
                    raise self._target.body.missing(role, side)
                return segment, self._target.body.segment(role, side)
        raise SinewError(f"{self._shape.name}: its bone '{bone}' is not a part of the body that Sinew knows")
