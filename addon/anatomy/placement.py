# SPDX-License-Identifier: GPL-3.0-or-later
"""From fractions to metres: the tissues of a preset on one body (ALGORITHM 9)."""

from mathutils import Matrix, Vector

from ..errors import SinewError
from ..tissue_io import TissueShape
from .preset_file import JOINTS, Attachment, MuscleRule, Preset, SphereRule
from .segments import Body, Segment
from .skin_surface import SkinSurface

# From the axis to the skin by the segment's length, as the MakeHuman body has it: for a rig without a skin.
RADIUS_OF_LENGTH = {
    "pelvis": 1.4,
    "chest": 0.38,
    "shoulder_girdle": 0.4,
    "upper_arm": 0.18,
    "forearm": 0.12,
    "hand": 0.22,
    "thigh": 0.16,
    "shin": 0.09,
    "foot": 0.24,
}
# A ray toward the body's middle can leave through the other leg; no limb is thicker than this.
LARGEST_OF_RADIUS = 2.0
SHORTEST_OF_SEGMENT = 0.01
# How far past its ends a segment still says where outward is.
PAST_ENDS = 0.3


def place(preset: Preset, body: Body, skin: SkinSurface | None) -> list[TissueShape]:
    """Each tissue of the preset, as the body's bones and skin (or usual proportions, without one) put it."""
    return [
        _muscle(rule, side, body, skin) if isinstance(rule, MuscleRule) else _sphere(rule, side, body, skin)
        for rule in preset.tissues
        for side in rule.sides
    ]


def _muscle(rule: MuscleRule, side: str, body: Body, skin: SkinSurface | None) -> TissueShape:
    origin = _attached(rule.origin, side, body, skin)
    insertion = _attached(rule.insertion, side, body, skin)
    length_m = (insertion - origin).length
    name = f"{rule.name}.{side}"
    if length_m < SHORTEST_OF_SEGMENT * body.segment(rule.origin.segment, side).length:
        raise SinewError(f"'{name}' would have no length: its origin and insertion fall on one point of this rig")
    belly_m = length_m * (1.0 - rule.origin_tendon - rule.insertion_tendon)
    width_m = belly_m * rule.width_ratio
    line = (insertion - origin) / length_m
    centre = origin + line * (length_m * rule.origin_tendon + belly_m / 2)
    to_skin = skin.toward_skin(centre) if skin is not None else None
    return TissueShape(
        name=name,
        kind="MUSCLE",
        origin_bone=_bone(rule.origin, side, body),
        insertion_bone=_bone(rule.insertion, side, body),
        centre=centre,
        rotation=_axes(to_skin or _from_bone(rule, side, body, centre), line).to_quaternion(),
        semi_axes=Vector((width_m * rule.thickness_ratio, width_m, belly_m)) / 2,
        origin_tendon=length_m * rule.origin_tendon,
        insertion_tendon=length_m * rule.insertion_tendon,
        volume_keeping=rule.volume_keeping,
    )


def _sphere(rule: SphereRule, side: str, body: Body, skin: SkinSurface | None) -> TissueShape:
    role, along = JOINTS[rule.joint]
    segment = body.segment(role, side)
    centre = segment.point(along)
    has_skin = skin is not None and skin.is_inside(centre)
    to_skin_m = skin.nearest_distance(centre) if has_skin else _usual_radius(segment)
    bone = segment.bone_at(along)
    return TissueShape(
        name=f"{rule.name}.{side}",
        kind="SPHERE",
        origin_bone=bone,
        insertion_bone=bone,
        centre=centre,
        rotation=_axes(segment.front, segment.axis).to_quaternion(),
        semi_axes=Vector((1, 1, 1)) * (rule.radius * to_skin_m),
    )


def _attached(at: Attachment, side: str, body: Body, skin: SkinSurface | None) -> Vector:
    segment = body.segment(at.segment, side)
    axis_point, direction = segment.point(at.along), segment.direction(at.around_deg)
    return axis_point + direction * (at.depth * _radius(segment, axis_point, direction, skin))


def _bone(at: Attachment, side: str, body: Body) -> str:
    """The bone that an attachment moves with; told from another segment, the end nearest to it carries it."""
    carrier = body.segment(at.carried_by, side)
    if at.carried_by == at.segment:
        return carrier.bone_at(at.along)
    return carrier.bone_at(carrier.along(body.segment(at.segment, side).point(at.along)))


def _radius(segment: Segment, axis_point: Vector, direction: Vector, skin: SkinSurface | None) -> float:
    """From the axis to the skin in one direction."""
    usual_m = _usual_radius(segment)
    measured_m = skin.distance_along(axis_point, direction) if skin is not None else None
    return min(measured_m or usual_m, LARGEST_OF_RADIUS * usual_m)


def _usual_radius(segment: Segment) -> float:
    return RADIUS_OF_LENGTH[segment.role] * segment.length


def _from_bone(rule: MuscleRule, side: str, body: Body, centre: Vector) -> Vector:
    """From the bone through the belly's middle, of the two segments that tell the attachments the one alongside."""
    segments = [body.segment(at.segment, side) for at in (rule.origin, rule.insertion)]
    beside = min(segments, key=lambda segment: abs(segment.along(centre) - 0.5))
    foot = beside.point(min(max(beside.along(centre), -PAST_ENDS), 1 + PAST_ENDS))
    outward = centre - foot
    return outward if outward.length > SHORTEST_OF_SEGMENT * beside.length else beside.front


def _axes(outward: Vector, line: Vector) -> Matrix:
    """Columns x (outward, square to the line), y, z (the line)."""
    x = outward - line * outward.dot(line)
    x = x.normalized() if x.length > 1e-6 else line.orthogonal().normalized()
    return Matrix((x, line.cross(x), line)).transposed()
