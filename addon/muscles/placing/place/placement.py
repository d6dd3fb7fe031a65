# SPDX-License-Identifier: GPL-3.0-or-later
"""The tissues of a preset on one body, in metres (docs/mathematics/fitting.md, Placement)."""

import math
from dataclasses import replace

from mathutils import Vector

from ....errors import SinewError
from ....scene.tissue_empty import TissueShape
from ...axes import axes_along
from ..fit.skin_surface import SkinSurface
from ..recognise.body import ON_FOUR_LEGS, SWIMMING, UPRIGHT, WINGED, Body, Segment
from ..recognise.body_parts import (
    CENTRAL_ROLES,
    DIGIT_ROLES,
    DISTAL,
    MIDDLE,
    OPTIONAL_ROLES,
    PROXIMAL,
    TRUNK_ROLES,
    BodyPart,
    part_label,
)
from ..recognise.kind import HUMAN
from .preset_file import JOINTS, Attachment, Preset, Rule, SpanRule, SphereRule, StuffingRule
from .strands import joined

SEPARATE, JOINED = "SEPARATE", "JOINED"
OTHER_SIDE = {"L": "R", "R": "L"}
JOINT_OF_SPINE = "joint between its ends"

# Distance from the axis to the skin as a fraction of the segment's length: in front, at the sides, behind. Measured on the
# MakeHuman body and used for a rig without a skin.
RADIUS_OF_LENGTH = {
    "pelvis": (1.4, 1.25, 0.55),
    "abdomen": (1.0, 0.68, 0.16),
    "chest": (0.43, 0.5, 0.15),
    "neck": (0.5, 0.56, 0.5),
    "head": (0.65, 0.45, 0.58),
    "jaw": (0.3, 0.3, 0.3),
    "tail_base": (0.16, 0.16, 0.16),
    "tail_middle": (0.11, 0.11, 0.11),
    "tail_tip": (0.04, 0.04, 0.04),
    "shoulder_girdle": (0.35, 0.4, 0.55),
    "upper_arm": (0.2, 0.16, 0.2),
    "forearm": (0.14, 0.12, 0.12),
    "hand": (0.18, 0.38, 0.15),
    "fingers": (0.5, 0.2, 0.15),
    "thigh": (0.24, 0.15, 0.14),
    "shin": (0.07, 0.12, 0.16),
    "foot": (0.16, 0.2, 0.32),
    "toes": (0.3, 0.3, 0.6),
}
# The same for a body on four legs, from the outline of Rigify's cat. How long the neck, the head and the feet are differs
# between animals and rigs more than how thick they are: these are fractions of the length of the trunk.
RADIUS_OF_TRUNK_ON_FOURS = {
    "neck": (0.12, 0.11, 0.11),
    "head": (0.19, 0.12, 0.04),
    "hand": (0.03, 0.047, 0.03),
    "fingers": (0.033, 0.053, 0.027),
    "toes": (0.034, 0.06, 0.034),
}
RADIUS_ON_FOURS = RADIUS_OF_LENGTH | {
    "pelvis": (1.1, 0.75, 0.32),
    "abdomen": (0.95, 0.6, 0.35),
    "chest": (0.6, 0.32, 0.25),
    "neck": (1.1, 1.0, 1.0),
    "head": (0.62, 0.4, 0.12),
    "shoulder_girdle": (0.4, 0.3, 0.4),
    "upper_arm": (0.3, 0.22, 0.35),
    "forearm": (0.16, 0.14, 0.16),
    "hand": (0.5, 0.8, 0.5),
    "fingers": (0.5, 0.8, 0.4),
    "thigh": (0.38, 0.3, 0.5),
    "shin": (0.16, 0.16, 0.3),
    "foot": (0.1, 0.1, 0.12),
    "toes": (0.4, 0.7, 0.4),
}
# The same for the digits of a hand, which all creatures share.
RADIUS_OF_DIGITS = {
    role: (0.3, 0.34, 0.26)
    if role.endswith((MIDDLE, DISTAL))
    else (0.2, 0.2, 0.13)
    if role.endswith(PROXIMAL)
    else (0.16, 0.13, 0.12)
    for role in DIGIT_ROLES
} | {"thumb_metacarpal": (0.28, 0.25, 0.2), "thumb_proximal": (0.27, 0.3, 0.24)}
# The same for a fish: about a tenth to a fifth of its length thick, in parts of about a sixth of its length.
RADIUS_OF_FISH = RADIUS_OF_LENGTH | {
    "head": (0.4, 0.3, 0.4),
    "chest": (0.6, 0.45, 0.6),
    "abdomen": (0.6, 0.45, 0.6),
    "pelvis": (0.5, 0.35, 0.5),
    "tail_base": (0.4, 0.25, 0.4),
    "tail_middle": (0.3, 0.18, 0.3),
    "tail_tip": (0.3, 0.06, 0.3),
    "upper_arm": (0.3, 0.08, 0.3),
    "forearm": (0.3, 0.06, 0.3),
    "hand": (0.3, 0.04, 0.3),
}
# The same for a bird: thin wings, and thin legs from the ankle.
RADIUS_OF_BIRD = RADIUS_ON_FOURS | {
    "chest": (0.8, 0.45, 0.3),
    "neck": (0.4, 0.3, 0.4),
    "upper_arm": (0.14, 0.08, 0.16),
    "forearm": (0.08, 0.05, 0.1),
    "hand": (0.04, 0.02, 0.06),
    "foot": (0.08, 0.08, 0.08),
}
USUAL_RADIUS = {WINGED: RADIUS_OF_BIRD, UPRIGHT: RADIUS_OF_LENGTH, ON_FOUR_LEGS: RADIUS_ON_FOURS, SWIMMING: RADIUS_OF_FISH}
# Largest measured distance to the skin, in usual distances. A ray towards the middle of the body can leave through the other
# leg, a ray across the chest through an arm.
LARGEST_OF_RADIUS = 2.0
LARGEST_OF_CHEST = 1.15
# Shortest muscle, and shortest distance from the axis that defines a direction, as fractions of the segment's length.
SHORTEST_OF_SEGMENT = 0.01
# How far beyond its ends a segment still defines the outward direction, as a fraction of its length.
PAST_ENDS = 0.3


def place(preset: Preset, body: Body, skin: SkinSurface | None, strands: str = SEPARATE) -> list[TissueShape]:
    """The tissues of a preset, placed by the body's bones and skin; by usual proportions without a skin.

    strands: JOINED makes one belly of the strands of a muscle. Tissues on parts that the body lacks are left out, and
    muscles whose ends are at the same point of this body; `left_out` and `not_placed` return their names. Raises
    SinewError as `require` does, and if no tissue is left.
    """
    require(preset, body)
    body = body.with_proportions(preset.proportions)
    shapes: list[TissueShape] = []
    bellies: dict[str, list[TissueShape]] = {}
    for rule in preset.tissues:
        for side in rule.sides:
            if _reasons_to_leave_out(rule, side, body):
                continue
            shape = _placed(rule, side, body, skin)
            if shape is None:
                continue
            if strands == JOINED and isinstance(rule, SpanRule) and rule.belly:
                bellies.setdefault(_named(rule.belly, side), []).append(shape)
            else:
                shapes.append(shape)
    if not shapes and not bellies:
        raise SinewError(f"No muscle of {preset.name} has a length on this rig: its bones are too short or at one point")
    return with_existing_wraps(shapes + [joined(bellies[name], name) for name in bellies])


def not_placed(preset: Preset, body: Body, shapes: list[TissueShape]) -> list[str]:
    """The names of the tissues whose parts the rig has, but which were left out. shapes: what was added.

    Stuffing that only fills gaps is not named.
    """
    placed = {shape.name for shape in shapes}
    return [
        _named(rule.name, side)
        for rule in preset.tissues
        for side in rule.sides
        if not (preset.fills and _is_stuffing(rule))
        and not _reasons_to_leave_out(rule, side, body)
        and _named(rule.name, side) not in placed
        and not (isinstance(rule, SpanRule) and rule.belly and _named(rule.belly, side) in placed)
    ]


def _is_stuffing(rule: Rule) -> bool:
    return isinstance(rule, StuffingRule) or (isinstance(rule, SpanRule) and rule.kind == "STUFFING")


def why_not_placed(preset: Preset) -> str:
    """Why tissues whose parts the rig has are left out."""
    if preset.creature in ("", HUMAN):
        return "their ends are at the same point"
    return "they lie outside of the mesh, or their ends are at the same point"


def require(preset: Preset, body: Body) -> None:
    """Raises SinewError if the parts of the body do not suffice. The message names the part and the remedy.

    They do not suffice if no tissue can be placed, or if the body is of a known kind and one side lacks a bone that the
    other side has: the bone has another name, and the user can tell which.
    """
    lacking = [part for rule in preset.tissues for side in rule.sides for part in _lacking(rule, side, body)]
    for role, side in lacking:
        if (
            (role, side) in body.recognised.expected
            and role not in OPTIONAL_ROLES
            and body.has(role, OTHER_SIDE.get(side, ""))
        ):
            raise body.missing(role, side)
    if all(_reasons_to_leave_out(rule, side, body) for rule in preset.tissues for side in rule.sides):
        raise body.missing(*lacking[0])


def left_out(preset: Preset, body: Body) -> dict[str, list[str]]:
    """The names of the tissues that are left out, by the label of each part that they need and the body lacks."""
    missing: dict[str, list[str]] = {}
    for rule in preset.tissues:
        for side in rule.sides:
            for part in _reasons_to_leave_out(rule, side, body):
                missing.setdefault(part, []).append(_named(rule.name, side))
    return missing


def _reasons_to_leave_out(rule: Rule, side: str, body: Body) -> list[str]:
    """The labels of what the rule needs and the body lacks."""
    lacking = _lacking(rule, side, body)
    if lacking:
        one_sided = {part for part in lacking if body.has(part[0], OTHER_SIDE.get(part[1], ""))}
        return [part_label(*part) if part in one_sided else part_label(part[0]) for part in lacking]
    return [JOINT_OF_SPINE] if _needs_joint_of_spine(rule, side, body) else []


def _lacking(rule: Rule, side: str, body: Body) -> list[BodyPart]:
    roles = sorted(role for role in rule.roles if not body.has(role, side))
    return [(role, "" if role in CENTRAL_ROLES else side) for role in roles]


def _needs_joint_of_spine(rule: Rule, side: str, body: Body) -> bool:
    """Whether a muscle joins two parts of the trunk that one bone carries, on a spine too short to have this joint."""
    if not isinstance(rule, SpanRule) or rule.kind != "MUSCLE":
        return False
    if _is_fixed_blade(rule, side, body):
        return True
    origin, insertion = rule.origin.carried_by, rule.insertion.carried_by
    if origin == insertion or not {origin, insertion} <= set(TRUNK_ROLES):
        return False
    spine = {bone for role in TRUNK_ROLES if body.has(role, "") for bone in body.segment(role, "").bones}
    return len(spine) < len(TRUNK_ROLES) and _bone(rule.origin, side, body) == _bone(rule.insertion, side, body)


def _is_fixed_blade(rule: SpanRule, side: str, body: Body) -> bool:
    """Whether a muscle joins the chest and a shoulder blade that the rig has no bone for."""
    roles = {rule.origin.carried_by, rule.insertion.carried_by}
    if "shoulder_girdle" not in roles or body.has_bone("shoulder_girdle", side):
        return False
    return _bone(rule.origin, side, body) == _bone(rule.insertion, side, body)


def with_existing_wraps(shapes: list[TissueShape]) -> list[TissueShape]:
    """The tissues without the names of wrap spheres that were left out."""
    names = {shape.name for shape in shapes}
    if all(wrap in names for shape in shapes for wrap in shape.wraps):
        return shapes
    return [replace(shape, wraps=tuple(wrap for wrap in shape.wraps if wrap in names)) for shape in shapes]


def _named(name: str, side: str) -> str:
    return name if side == "C" else f"{name}.{side}"


def _placed(rule: Rule, side: str, body: Body, skin: SkinSurface | None) -> TissueShape | None:
    if isinstance(rule, SphereRule):
        return _sphere(rule, side, body, skin)
    if isinstance(rule, StuffingRule):
        return _stuffing(rule, side, body, skin)
    return _span(rule, side, body, skin)


def _span(rule: SpanRule, side: str, body: Body, skin: SkinSurface | None) -> TissueShape | None:
    """A tissue between two attachments; None if it has no length."""
    origin = _attached(rule.origin, side, body, skin)
    insertion = _attached(rule.insertion, side, body, skin)
    length_m = (insertion - origin).length
    name = _named(rule.name, side)
    if length_m < SHORTEST_OF_SEGMENT * body.segment(rule.origin.segment, side).length:
        return None
    belly_m = length_m * (1.0 - rule.origin_tendon - rule.insertion_tendon)
    width_m = belly_m * rule.width_ratio
    line = (insertion - origin) / length_m
    centre = origin + line * (length_m * rule.origin_tendon + belly_m / 2)
    to_skin = skin.toward_skin(centre) if skin is not None else None
    from_bone = _from_bone(rule, side, body, centre)
    thickness_m = width_m * rule.thickness_ratio
    if rule.lift:
        centre = _lifted(rule, side, body, centre, to_skin, thickness_m / 2)
    origin_bone = _bone(rule.origin, side, body)
    return TissueShape(
        name=name,
        kind=rule.kind,
        origin_bone=origin_bone,
        insertion_bone=_bone(rule.insertion, side, body) if rule.kind == "MUSCLE" else origin_bone,
        centre=centre,
        rotation=axes_along(line, to_skin or from_bone).to_quaternion(),
        semi_axes=Vector((thickness_m, width_m, belly_m)) / 2,
        origin_tendon=length_m * rule.origin_tendon,
        insertion_tendon=length_m * rule.insertion_tendon,
        volume_keeping=rule.volume_keeping,
        via_points=tuple((_bone(at, side, body), _attached(at, side, body, skin)) for at in rule.via),
        wraps=tuple(_named(wrap, side) for wrap in rule.wraps),
    )


def _sphere(rule: SphereRule, side: str, body: Body, skin: SkinSurface | None) -> TissueShape:
    role, along = JOINTS[rule.joint]
    segment = body.segment(role, side)
    centre = segment.point(along)
    has_skin = skin is not None and skin.is_inside(centre)
    to_skin_m = skin.nearest_distance(centre) if has_skin else usual_radius(segment, segment.outer)
    bone = segment.bone_at(along)
    return TissueShape(
        name=_named(rule.name, side),
        kind="SPHERE",
        origin_bone=bone,
        insertion_bone=bone,
        centre=centre,
        rotation=axes_along(segment.axis, segment.front).to_quaternion(),
        semi_axes=Vector((1, 1, 1)) * (rule.radius * to_skin_m),
    )


def _stuffing(rule: StuffingRule, side: str, body: Body, skin: SkinSurface | None) -> TissueShape:
    """A rigid ellipsoid midway between the skin in front and behind, and between the skin at both sides."""
    segment = body.segment(rule.segment, side)
    along = (rule.start + rule.end) / 2
    axis_point = segment.point(along)
    front, back, outer, inner = (
        radius(segment, axis_point, segment.direction(around_deg), skin) for around_deg in (0, 180, 90, 270)
    )
    bone = segment.bone_at(along)
    return TissueShape(
        name=_named(rule.name, side),
        kind="STUFFING",
        origin_bone=bone,
        insertion_bone=bone,
        centre=axis_point + segment.front * ((front - back) / 2) + segment.outer * ((outer - inner) / 2),
        rotation=axes_along(segment.axis, segment.front).to_quaternion(),
        semi_axes=Vector(
            (
                rule.width * (front + back) / 2,
                rule.width * (outer + inner) / 2,
                abs(rule.end - rule.start) * segment.length / 2,
            )
        ),
    )


def _attached(at: Attachment, side: str, body: Body, skin: SkinSurface | None) -> Vector:
    """The position of an attachment, armature space."""
    segment = body.segment(at.segment, side)
    axis_point, direction = segment.point(at.along), segment.direction(at.around_deg)
    return axis_point + direction * (at.depth * radius(segment, axis_point, direction, skin))


def _bone(at: Attachment, side: str, body: Body) -> str:
    """The bone that carries an attachment. On a segment other than the one that defines its position, the nearest bone."""
    carrier = body.segment(at.carried_by, side)
    if at.carried_by == at.segment:
        return carrier.bone_at(at.along)
    return carrier.bone_at(carrier.along(body.segment(at.segment, side).point(at.along)))


def radius(segment: Segment, axis_point: Vector, direction: Vector, skin: SkinSurface | None) -> float:
    """The distance from a point of the axis to the skin in one direction, m."""
    usual_m = usual_radius(segment, direction)
    measured_m = skin.distance_along(axis_point, direction) if skin is not None else None
    return min(measured_m or usual_m, (LARGEST_OF_CHEST if segment.role == "chest" else LARGEST_OF_RADIUS) * usual_m)


def usual_radius(segment: Segment, direction: Vector) -> float:
    """The usual distance from the axis to the skin in a direction, m: the radius of an ellipse."""
    front, sideways, back = RADIUS_OF_DIGITS.get(segment.role) or USUAL_RADIUS[segment.build][segment.role]
    length_m = segment.length
    if segment.proportions:
        front, sideways, back = segment.proportions
    elif segment.on_fours and segment.trunk_m and segment.role in RADIUS_OF_TRUNK_ON_FOURS:
        (front, sideways, back), length_m = RADIUS_OF_TRUNK_ON_FOURS[segment.role], segment.trunk_m
    ahead, across = direction.dot(segment.front), direction.dot(segment.outer)
    return length_m / math.hypot(ahead / (front if ahead > 0 else back), across / sideways)


def _lifted(
    rule: SpanRule, side: str, body: Body, centre: Vector, to_skin: Vector | None, half_thickness_m: float
) -> Vector:
    """The centre of the belly, moved out by the rule's fraction of the distance that brings its outer side to the skin."""
    if to_skin is None:
        outward = _from_bone(rule, side, body, centre)
        segment = _nearest_segment(rule, side, body, centre)
        free_m = usual_radius(segment, outward.normalized()) - outward.length - half_thickness_m
        return centre + outward.normalized() * (rule.lift * max(free_m, 0.0))
    free_m = to_skin.length - half_thickness_m
    return centre + to_skin.normalized() * (rule.lift * max(free_m, 0.0))


def _nearest_segment(rule: SpanRule, side: str, body: Body, centre: Vector) -> Segment:
    """The segment of origin or insertion whose middle is nearer to the centre of the belly, along its axis."""
    segments = [body.segment(at.segment, side) for at in (rule.origin, rule.insertion)]
    return min(segments, key=lambda segment: abs(segment.along(centre) - 0.5))


def _from_bone(rule: SpanRule, side: str, body: Body, centre: Vector) -> Vector:
    """The vector from the segment's axis to the centre of the belly; the segment's front if the centre is on the axis."""
    segment = _nearest_segment(rule, side, body, centre)
    on_axis = segment.point(min(max(segment.along(centre), -PAST_ENDS), 1 + PAST_ENDS))
    outward = centre - on_axis
    return outward if outward.length > SHORTEST_OF_SEGMENT * segment.length else segment.front
