# SPDX-License-Identifier: GPL-3.0-or-later
"""Tissues as Blender keeps them: an Empty that *is* the rest-pose ellipsoid. The only reader and writer of these Empties.

A tissue's Empty is a child of its origin bone. In the rest pose its location is the ellipsoid's centre, its rotation
the axes (local z from origin to insertion) and its scale the semi-axes; everything else stands in `object.sinew`.
Nothing is stored twice, so moving, turning or scaling the Empty edits the tissue.

The posed state is shown through the Empty's delta transforms, which leave those values alone.
"""

from dataclasses import dataclass

import bpy
import numpy as np
from mathutils import Euler, Matrix, Quaternion, Vector

from . import rig_io
from .errors import SinewError

RIGID_KINDS = frozenset({"BONE", "STUFFING", "SPHERE"})
SMALLEST_SEMI_AXIS_M = 1e-6


@dataclass(frozen=True)
class TissueShape:
    """A tissue in the rest pose, in armature space (metres; ALGORITHM 2).

    `rotation`'s local z runs from origin to insertion. The belly's ends are `semi_axes.z` from the centre; a muscle's
    tendons go on from there to its origin and insertion. A rigid kind has the same bone twice and no tendons.
    `via_points` are (bone, point) that the path runs through from origin to insertion, `wraps` the names of spheres of
    the same rig that it bends around.
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


def settings_of(empties: list) -> list[tuple]:
    """What of each Empty's settings its tissue depends on, to compare."""
    return [
        (
            empty.name,
            empty.rotation_mode,
            empty.empty_display_size,
            empty.parent_bone,
            own.kind,
            own.insertion_bone,
            own.origin_tendon,
            own.insertion_tendon,
            own.volume_keeping,
        )
        for empty, own in ((empty, empty.sinew) for empty in empties)
    ]


_POLLED = (("location", 3), ("rotation_euler", 3), ("rotation_quaternion", 4), ("scale", 3), ("matrix_parent_inverse", 16))


def transforms_of(rows: np.ndarray) -> np.ndarray:
    """(tissues, 29) float32: all transforms that tissues depend on, read in bulk.

    rows: the places of the Empties among all objects of the file.
    """
    count = len(bpy.data.objects)
    columns = []
    for name, width in _POLLED:
        values = np.empty(count * width, np.float32)
        bpy.data.objects.foreach_get(name, values)
        columns.append(values.reshape(count, width)[rows])
    return np.concatenate(columns, axis=1)


def rows_of(empties: list) -> np.ndarray:
    """The places of objects among all objects of the file."""
    places = {found.name_full: row for row, found in enumerate(bpy.data.objects)}
    return np.array([places[empty.name_full] for empty in empties], np.intp)


class Shown:
    """How one Empty shows its tissue in a pose: by delta transforms, so that what the person set stays as it is."""

    def __init__(self, empty, rig):
        self._location, self._rotation, scale = rest_transform(empty)
        self._scale = scale * empty.empty_display_size
        self._mode = empty.rotation_mode
        self._from_origin_bone = (
            Matrix.Translation((0.0, rig_io.bone_length(rig, empty.parent_bone), 0.0)) @ empty.matrix_parent_inverse
        ).inverted_safe()

    def show(self, empty, in_origin_bone: Matrix):
        """in_origin_bone: the unit sphere to the posed ellipsoid, in the space of the posed origin bone."""
        location, rotation, scale = (self._from_origin_bone @ in_origin_bone).decompose()
        empty.delta_location = location - self._location
        empty.delta_scale = [wanted / own for wanted, own in zip(scale, self._scale)]
        turn = rotation @ self._rotation.inverted()
        if self._mode == "QUATERNION":
            empty.delta_rotation_quaternion = turn
        elif self._mode != "AXIS_ANGLE":  # Blender gives scripts no delta for an axis and angle
            empty.delta_rotation_euler = turn.to_euler(self._mode)


def show_rest(empty):
    """Takes the delta transforms away: the Empty is the rest-pose ellipsoid, carried by its origin bone alone."""
    for name, nothing in (
        ("delta_location", Vector()),
        ("delta_scale", Vector((1.0, 1.0, 1.0))),
        ("delta_rotation_quaternion", Quaternion()),
        ("delta_rotation_euler", Euler()),
    ):
        if getattr(empty, name) != nothing:
            setattr(empty, name, nothing)
