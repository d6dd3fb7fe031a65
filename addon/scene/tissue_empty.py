# SPDX-License-Identifier: GPL-3.0-or-later
"""Tissues as Blender keeps them: an Empty that *is* the rest-pose ellipsoid. The only reader and writer of these Empties.

A tissue's Empty is a child of its origin bone. In the rest pose its location is the ellipsoid's centre, its rotation
the axes (local z from origin to insertion) and its scale the semi-axes; everything else stands in `object.sinew`.
Nothing is stored twice, so moving, turning or scaling the Empty edits the tissue.

A muscle's via points are Empties of their own, children of the bones that carry them, which point to the muscle's
Empty; the spheres that it goes round are pointers on that Empty.
"""

from dataclasses import dataclass

import bpy
from mathutils import Euler, Matrix, Quaternion, Vector

from ..errors import SinewError
from . import bone_geometry

RIGID_KINDS = frozenset({"BONE", "STUFFING", "SPHERE"})
SMALLEST_SEMI_AXIS_M = 1e-6
SAME_PLACE_M = 1e-7
VIA_SIZE_OF_BELLY = 0.2  # what a via point's Empty shows, over the belly's half length


@dataclass(frozen=True)
class TissueShape:
    """A tissue in the rest pose, in armature space (metres; ALGORITHM 2).

    `rotation`'s local z runs from origin to insertion. The belly's ends are `semi_axes.z` from the centre; a muscle's
    tendons go on from there to its origin and insertion. A rigid kind has the same bone twice and no tendons.
    `via_points` are (bone, point in the rest pose), ordered from origin to insertion, that a muscle's path passes;
    `wraps` the names of the rig's sphere tissues that it goes round. `skin_thickness`: how much thicker than elsewhere a
    skin is that is grown over the tissue.
    """

    name: str
    kind: str
    origin_bone: str
    insertion_bone: str
    centre: Vector
    rotation: Quaternion
    semi_axes: Vector
    origin_tendon: float = 0.0
    insertion_tendon: float = 0.0
    volume_keeping: float = 1.0
    via_points: tuple[tuple[str, Vector], ...] = ()
    wraps: tuple[str, ...] = ()
    skin_thickness: float = 0.0

    @property
    def origin(self) -> Vector:
        """Where a muscle takes its origin, armature space."""
        return self.centre - self.rotation @ Vector((0, 0, self.semi_axes.z + self.origin_tendon))

    @property
    def insertion(self) -> Vector:
        """Where a muscle inserts, armature space."""
        return self.centre + self.rotation @ Vector((0, 0, self.semi_axes.z + self.insertion_tendon))


def is_tissue(candidate) -> bool:
    """Whether an object is a tissue's Empty; asks without leaving a trace on objects that are none of ours."""
    return candidate.type == "EMPTY" and candidate.is_property_set("sinew") and candidate.sinew.kind not in ("NONE", "VIA")


def is_via(candidate) -> bool:
    """Whether an object is the Empty of a muscle's via point; asks without leaving a trace."""
    return candidate.type == "EMPTY" and candidate.is_property_set("sinew") and candidate.sinew.kind == "VIA"


def is_used(empty) -> bool:
    """False for an Empty that a person deleted: what other Empties point to stays in the file until it is saved."""
    return bool(empty.users_collection)


def rest_transform(empty) -> tuple[Vector, Quaternion, Vector]:
    """Location, rotation and scale as the person set them: without the delta transforms that show the pose."""
    if empty.rotation_mode == "QUATERNION":
        rotation = empty.rotation_quaternion.normalized()
    elif empty.rotation_mode == "AXIS_ANGLE":
        angle, *axis = empty.rotation_axis_angle
        rotation = Quaternion(axis, angle)
    else:
        rotation = empty.rotation_euler.to_quaternion()
    return empty.location.copy(), rotation, empty.scale.copy()


def read(empty, rig, vias: list | None = None) -> TissueShape:
    """The tissue that an Empty stands for. Raises SinewError where it stands for none, naming the Empty.

    vias: the Empties of its via points in their order; None looks for them.
    """
    settings = empty.sinew
    is_muscle = settings.kind == "MUSCLE"
    origin_bone = settings.origin_bone
    if empty.parent_type != "BONE" or not bone_geometry.has_bone(rig, origin_bone):
        raise SinewError(f"{empty.name}: origin bone '{origin_bone}' is not in {rig.name}; choose one in the Sinew panel")
    insertion_bone = settings.insertion_bone if is_muscle else origin_bone
    if not bone_geometry.has_bone(rig, insertion_bone):
        raise SinewError(
            f"{empty.name}: insertion bone '{insertion_bone}' is not in {rig.name}; choose one in the Sinew panel"
        )
    location, rotation, scale = rest_transform(empty)
    # an ellipsoid is its own mirror image, so a negative scale (Blender's Mirror) means the same widths
    scale = Vector(map(abs, scale)) * empty.empty_display_size
    if min(scale) < SMALLEST_SEMI_AXIS_M:
        raise SinewError(f"{empty.name}: scale {min(scale):g} is no width; give all three axes a scale above 0")
    placed = Matrix.LocRotScale(location, rotation, scale)
    centre, turned, semi_axes = (rest_parent(empty, rig) @ placed).decompose()
    return TissueShape(
        name=empty.name,
        kind=settings.kind,
        origin_bone=origin_bone,
        insertion_bone=insertion_bone,
        centre=centre,
        rotation=turned,
        semi_axes=semi_axes,
        origin_tendon=settings.origin_tendon if is_muscle else 0.0,
        insertion_tendon=settings.insertion_tendon if is_muscle else 0.0,
        volume_keeping=settings.volume_keeping,
        via_points=_read_via_points(rig, vias_of(empty) if vias is None else vias) if is_muscle else (),
        wraps=_read_wraps(empty) if is_muscle else (),
        skin_thickness=settings.skin_thickness,
    )


def vias_of(muscle) -> list:
    """The Empties of a muscle's via points in their order, read from the file now."""
    return vias_by_muscle(filter(is_via, bpy.data.objects)).get(muscle.name_full, [])


def vias_by_muscle(vias) -> dict[str, list]:
    """The Empties of via points in their order, by the full names of their muscles; without those that are deleted."""
    found: dict[str, list] = {}
    for via in vias:
        if via.sinew.muscle and is_used(via):
            found.setdefault(via.sinew.muscle.name_full, []).append(via)
    for own in found.values():
        own.sort(key=lambda via: (via.sinew.order, via.name))
    return found


def _read_via_points(rig, vias: list) -> tuple[tuple[str, Vector], ...]:
    points = []
    for via in vias:
        if via.parent != rig or via.parent_type != "BONE" or not bone_geometry.has_bone(rig, via.parent_bone):
            raise SinewError(
                f"{via.name}: bone '{via.parent_bone}' is not in {rig.name}; parent the via point to a bone of it, or delete it"
            )
        points.append((via.parent_bone, rest_parent(via, rig) @ via.location))
    return tuple(points)


def _read_wraps(empty) -> tuple[str, ...]:
    # a sphere that was deleted is simply no longer in the way
    spheres = [wrap.sphere for wrap in empty.sinew.wraps if wrap.sphere and is_used(wrap.sphere)]
    for sphere in spheres:
        if not is_tissue(sphere) or sphere.sinew.kind != "SPHERE" or sphere.parent != empty.parent:
            raise SinewError(
                f"{empty.name}: goes round {sphere.name}, which is no sphere of {empty.parent.name}; wrap another"
            )
    return tuple(dict.fromkeys(sphere.name for sphere in spheres))


def rest_parent(empty, rig) -> Matrix:
    """What the Empty's own location, rotation and scale are relative to, in the rest pose; armature space."""
    return bone_geometry.rest_tail(rig, empty.parent_bone) @ empty.matrix_parent_inverse


def create(rig, shape: TissueShape, collection):
    """A new Empty for a tissue, child of its origin bone, in `collection`, with those of its via points; returns it.

    Spheres that it goes round must be there already, or be given to `write_wraps` later.
    """
    empty = bpy.data.objects.new(shape.name, None)
    collection.objects.link(empty)
    empty.empty_display_type = "SPHERE"
    empty.empty_display_size = 1.0
    _hang(empty, rig, shape.origin_bone)
    empty.sinew.kind = shape.kind
    write(empty, shape, [])
    return empty


def _hang(empty, rig, bone: str):
    empty.parent = rig
    empty.parent_type = "BONE"
    empty.parent_bone = bone
    # with this inverse the Empty's own location, rotation and scale are in armature space
    empty.matrix_parent_inverse = bone_geometry.rest_tail(rig, bone).inverted()


def remove(empty, vias: list | None = None):
    """Removes a tissue's Empty and those of its via points; None looks for these."""
    for via in vias_of(empty) if vias is None else vias:
        discard(via)
    discard(empty)


def discard(empty):
    """Removes an Empty of ours, with the action that nothing but it played, as where its tension was keyed."""
    action = empty.animation_data.action if empty.animation_data else None
    bpy.data.objects.remove(empty)
    if action and action.users == 0:
        bpy.data.actions.remove(action)


def write(empty, shape: TissueShape, vias: list | None = None):
    """Gives an Empty the place, size and settings of `shape`, as seen from its own parent, and a muscle its course.

    vias: the Empties of its via points in their order; None looks for them.
    """
    matrix = Matrix.LocRotScale(shape.centre, shape.rotation, shape.semi_axes)
    location, rotation, scale = (rest_parent(empty, empty.parent).inverted() @ matrix).decompose()
    empty.location = location
    if empty.rotation_mode == "QUATERNION":
        empty.rotation_quaternion = rotation
    elif empty.rotation_mode == "AXIS_ANGLE":
        axis, angle = rotation.to_axis_angle()
        empty.rotation_axis_angle = (angle, *axis)
    else:
        empty.rotation_euler = _euler_of(rotation, empty.rotation_mode)
    empty.scale = scale / empty.empty_display_size
    settings = empty.sinew
    settings.insertion_bone = shape.insertion_bone if shape.kind == "MUSCLE" else ""
    settings.origin_tendon = shape.origin_tendon
    settings.insertion_tendon = shape.insertion_tendon
    settings.volume_keeping = shape.volume_keeping
    settings.skin_thickness = shape.skin_thickness
    if shape.kind == "MUSCLE":
        _write_via_points(empty, shape, vias_of(empty) if vias is None else vias)
        if _read_wraps(empty) != shape.wraps:
            spheres = {found.name: found for found in bpy.data.objects if found.parent == empty.parent and is_tissue(found)}
            write_wraps(empty, [spheres[name] for name in shape.wraps if name in spheres])


def _euler_of(rotation: Quaternion, order: str) -> Euler:
    """The rotation as angles in this order, exact to rounding also where the middle one is near 90 degrees.

    There Blender reads the outer two from tiny numbers, each with its own rounding; the last angle takes up what is amiss.
    """
    angles = rotation.to_euler(order)
    amiss = rotation @ angles.to_quaternion().inverted()
    last = "XYZ".index(order[-1])
    angles[last] += 2.0 * (amiss.x, amiss.y, amiss.z)[last] * (1.0 if amiss.w >= 0.0 else -1.0)
    return angles


def write_wraps(empty, spheres: list):
    """Makes a muscle go round these Empties of spheres, and no others."""
    wraps = empty.sinew.wraps
    wraps.clear()
    for sphere in spheres:
        wraps.add().sphere = sphere
    empty.update_tag()


def _write_via_points(empty, shape: TissueShape, present: list):
    for surplus in present[len(shape.via_points) :]:
        discard(surplus)
    for order, (bone, point) in enumerate(shape.via_points):
        if order < len(present):
            via = present[order]
            if via.parent_bone != bone:
                _hang(via, empty.parent, bone)
            via.sinew.order = order
            place = rest_parent(via, empty.parent).inverted() @ point
            if (via.location - place).length > SAME_PLACE_M:  # what was read is written back as it was
                via.location = place
        else:
            add_via(empty, bone, point, order)


def add_via(muscle, bone: str, point: Vector, order: int):
    """A new Empty for a via point of a muscle's Empty, at a point in the rest pose (armature space); returns it."""
    rig = muscle.parent
    via = bpy.data.objects.new(f"{muscle.name} via", None)
    next(iter(muscle.users_collection), bpy.context.scene.collection).objects.link(via)
    via.empty_display_type = "PLAIN_AXES"
    via.empty_display_size = VIA_SIZE_OF_BELLY * abs(muscle.scale.z) * muscle.empty_display_size
    _hang(via, rig, bone)
    via.location = point
    via.sinew.kind = "VIA"
    via.sinew.muscle = muscle
    via.sinew.order = order
    return via
