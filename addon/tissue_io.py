# SPDX-License-Identifier: GPL-3.0-or-later
"""Tissues as Blender keeps them: an Empty that *is* the rest-pose ellipsoid. The only reader and writer of these Empties.

A tissue's Empty is a child of its origin bone. In the rest pose its location is the ellipsoid's centre, its rotation
the axes (local z from origin to insertion) and its scale the semi-axes; everything else stands in `object.sinew`.
Nothing is stored twice, so moving, turning or scaling the Empty edits the tissue.

The posed state is shown through the Empty's delta transforms, which leave those values alone.
"""

from dataclasses import dataclass

import bpy
from mathutils import Matrix, Quaternion, Vector

from . import rig_io
from .errors import SinewError

RIGID_KINDS = frozenset({"BONE", "STUFFING", "SPHERE"})
SMALLEST_SEMI_AXIS_M = 1e-6


@dataclass(frozen=True)
class TissueShape:
    """A tissue in the rest pose, in armature space (metres; ALGORITHM 2).

    `rotation`'s local z runs from origin to insertion. The belly's ends are `semi_axes.z` from the centre; a muscle's
    tendons go on from there to its origin and insertion. A rigid kind has the same bone twice and no tendons.
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
    return candidate.type == "EMPTY" and candidate.is_property_set("sinew") and candidate.sinew.kind != "NONE"


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


def read(empty, rig) -> TissueShape:
    """The tissue that an Empty stands for. Raises SinewError where it stands for none, naming the Empty."""
    settings = empty.sinew
    is_muscle = settings.kind == "MUSCLE"
    origin_bone = settings.origin_bone
    if empty.parent_type != "BONE" or not rig_io.has_bone(rig, origin_bone):
        raise SinewError(f"{empty.name}: origin bone '{origin_bone}' is not in {rig.name}; choose one in the Sinew panel")
    insertion_bone = settings.insertion_bone if is_muscle else origin_bone
    if not rig_io.has_bone(rig, insertion_bone):
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
    )


def rest_parent(empty, rig) -> Matrix:
    """What the Empty's own location, rotation and scale are relative to, in the rest pose; armature space."""
    return rig_io.rest_tail(rig, empty.parent_bone) @ empty.matrix_parent_inverse


def show(empty, posed: Matrix, parent_posed: Matrix):
    """Shows a tissue in a pose by delta transforms alone.

    posed: the unit sphere to the posed ellipsoid; parent_posed: the tail of its origin bone; both in armature space.
    """
    location, rotation, scale = rest_transform(empty)
    wanted_location, wanted_rotation, wanted_scale = (
        (parent_posed @ empty.matrix_parent_inverse).inverted_safe() @ posed
    ).decompose()
    _set_delta(empty, "delta_location", wanted_location - location)
    size = empty.empty_display_size
    _set_delta(empty, "delta_scale", Vector(w / (s * size) for w, s in zip(wanted_scale, scale)))
    turn = wanted_rotation @ rotation.inverted()
    if empty.rotation_mode == "QUATERNION":
        _set_delta(empty, "delta_rotation_quaternion", turn)
    elif empty.rotation_mode != "AXIS_ANGLE":  # Blender gives scripts no delta for an axis and angle
        _set_delta(empty, "delta_rotation_euler", turn.to_euler(empty.rotation_mode))


def show_rest(empty):
    """Takes the delta transforms away: the Empty is the rest-pose ellipsoid, carried by its origin bone alone."""
    _set_delta(empty, "delta_location", Vector())
    _set_delta(empty, "delta_scale", Vector((1.0, 1.0, 1.0)))
    _set_delta(empty, "delta_rotation_quaternion", Quaternion())
    _set_delta(empty, "delta_rotation_euler", Vector())


def _set_delta(empty, name: str, value):
    # each write makes Blender evaluate the object again, so one that changes nothing visible is left out
    if max(abs(a - b) for a, b in zip(getattr(empty, name), value)) > 1e-7:
        setattr(empty, name, value)


def state(empty) -> tuple:
    """All of an Empty that its tissue depends on, cheap to read and to compare; see `read`."""
    settings = empty.sinew
    return (
        *empty.location,
        *empty.scale,
        *(empty.rotation_quaternion if empty.rotation_mode == "QUATERNION" else empty.rotation_euler),
        *(empty.rotation_axis_angle if empty.rotation_mode == "AXIS_ANGLE" else ()),
        empty.rotation_mode,
        empty.matrix_parent_inverse.copy().freeze(),
        empty.empty_display_size,
        empty.parent_type,
        settings.kind,
        settings.origin_bone,
        settings.insertion_bone,
        settings.origin_tendon,
        settings.insertion_tendon,
        settings.volume_keeping,
    )


def create(rig, shape: TissueShape, collection):
    """A new Empty for a tissue, child of its origin bone, in `collection`; returns the object."""
    empty = bpy.data.objects.new(shape.name, None)
    collection.objects.link(empty)
    empty.empty_display_type = "SPHERE"
    empty.empty_display_size = 1.0
    empty.parent = rig
    empty.parent_type = "BONE"
    empty.parent_bone = shape.origin_bone
    # with this inverse the Empty's own location, rotation and scale are the tissue's, in armature space
    empty.matrix_parent_inverse = rig_io.rest_tail(rig, shape.origin_bone).inverted()
    empty.sinew.kind = shape.kind
    write(empty, shape)
    return empty


def write(empty, shape: TissueShape):
    """Gives an Empty the place, size and settings of `shape`, as seen from its own parent."""
    matrix = Matrix.LocRotScale(shape.centre, shape.rotation, shape.semi_axes)
    location, rotation, scale = (rest_parent(empty, empty.parent).inverted() @ matrix).decompose()
    empty.location = location
    if empty.rotation_mode == "QUATERNION":
        empty.rotation_quaternion = rotation
    elif empty.rotation_mode == "AXIS_ANGLE":
        axis, angle = rotation.to_axis_angle()
        empty.rotation_axis_angle = (angle, *axis)
    else:
        empty.rotation_euler = rotation.to_euler(empty.rotation_mode)
    empty.scale = scale / empty.empty_display_size
    settings = empty.sinew
    settings.insertion_bone = shape.insertion_bone if shape.kind == "MUSCLE" else ""
    settings.origin_tendon = shape.origin_tendon
    settings.insertion_tendon = shape.insertion_tendon
    settings.volume_keeping = shape.volume_keeping

