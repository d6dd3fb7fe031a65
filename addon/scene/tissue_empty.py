# SPDX-License-Identifier: GPL-3.0-or-later
"""Reads and writes the Empties that are tissues and via points.

The Empty of a tissue is a child of its origin bone. In the rest pose its location is the centre of the ellipsoid, its
rotation the axes (local z from origin to insertion) and its scale the semi-axes. `object.sinew.tissue` holds the other
settings. Nothing is stored twice, so moving, rotating or scaling the Empty edits the tissue.

A via point is a separate Empty, a child of the bone that moves it, with a pointer to the Empty of its muscle. The spheres
that a muscle wraps around are pointers on its Empty.
"""

import math
from dataclasses import dataclass

import bpy
from mathutils import Euler, Matrix, Quaternion, Vector

from ..errors import SinewError
from . import animated_value, bone_geometry, stored_settings
from .editable_collections import editable_collections_of

RIGID_KINDS = frozenset({"BONE", "STUFFING", "SPHERE"})
SMALLEST_SEMI_AXIS_M = 1e-6
SAME_POSITION_M = 1e-7
VIA_SIZE_OF_BELLY = 0.2  # display size of a via point over the half length of the belly


@dataclass(frozen=True)
class TissueShape:
    """A tissue in the rest pose, in armature space and metres (docs/mathematics/muscles.md, Tissues).

    rotation: its local z runs from origin to insertion. The belly ends at the distance `semi_axes.z` from the centre; the
    tendons of a muscle continue from there to its origin and insertion. A rigid kind has the same bone twice and no tendons.
    via_points: (bone, point in the rest pose), ordered from origin to insertion, that the path of a muscle passes through.
    wraps: the names of the spheres that it wraps around. skin_thickness: added thickness of a skin grown over the tissue.
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
    def volume(self) -> float:
        """The volume of its ellipsoid, m3."""
        return 4 / 3 * math.pi * math.prod(self.semi_axes)

    @property
    def origin(self) -> Vector:
        """The origin of a muscle, in armature space."""
        return self.centre - self.rotation @ Vector((0, 0, self.semi_axes.z + self.origin_tendon))

    @property
    def insertion(self) -> Vector:
        """The insertion of a muscle, in armature space."""
        return self.centre + self.rotation @ Vector((0, 0, self.semi_axes.z + self.insertion_tendon))


def is_tissue(candidate) -> bool:
    """Whether an object is the Empty of a tissue. Does not create settings on objects that have none."""
    settings = stored_settings.tissue_of(candidate) if candidate.type == "EMPTY" else None
    return settings is not None and settings.kind not in ("NONE", "VIA")


def is_via(candidate) -> bool:
    """Whether an object is the Empty of a via point. Does not create settings on objects that have none."""
    settings = stored_settings.tissue_of(candidate) if candidate.type == "EMPTY" else None
    return settings is not None and settings.kind == "VIA"


def is_used(empty) -> bool:
    """Whether an Empty is in a collection. A deleted Empty stays in the file while other Empties point to it."""
    return bool(empty.users_collection)


def rest_transform(empty) -> tuple[Vector, Quaternion, Vector]:
    """Location, rotation and scale as the user set or keyed them, without the delta transforms that show the pose."""
    if empty.rotation_mode == "QUATERNION":
        rotation = empty.rotation_quaternion.normalized()
    elif empty.rotation_mode == "AXIS_ANGLE":
        angle, *axis = empty.rotation_axis_angle
        rotation = Quaternion(axis, angle)
    else:
        rotation = empty.rotation_euler.to_quaternion()
    return empty.location.copy(), rotation, empty.scale.copy()


def read(empty, rig, vias: list | None = None, depsgraph=None) -> TissueShape:
    """The tissue that an Empty is. Raises SinewError, naming the Empty, if its settings or transforms are not usable.

    vias: the Empties of its via points in order. None searches the file for them. depsgraph: the evaluation that keyed and
    driven values are read from. None reads what the user sees and edits.
    """
    values = animated_value.values_of(empty, depsgraph) if depsgraph else empty
    settings = empty.sinew.tissue
    is_muscle = settings.kind == "MUSCLE"
    origin_bone = settings.origin_bone
    if empty.parent_type != "BONE" or not bone_geometry.has_bone(rig, origin_bone):
        raise SinewError(f"{empty.name}: origin bone '{origin_bone}' is not in {rig.name}. Choose one in the Sinew panel")
    insertion_bone = settings.insertion_bone if is_muscle else origin_bone
    if not bone_geometry.has_bone(rig, insertion_bone):
        raise SinewError(
            f"{empty.name}: insertion bone '{insertion_bone}' is not in {rig.name}. Choose one in the Sinew panel"
        )
    location, rotation, scale = rest_transform(values)
    # an ellipsoid is symmetric, so a negative scale (Blender's Mirror) is the same ellipsoid
    scale = Vector(map(abs, scale)) * values.empty_display_size
    if min(scale) < SMALLEST_SEMI_AXIS_M:
        raise SinewError(f"{empty.name}: the scale must be above 0 on all three axes, not {min(scale):g}")
    in_parent, evaluated = Matrix.LocRotScale(location, rotation, scale), values.sinew.tissue
    centre, rotation, semi_axes = (rest_parent(empty, rig) @ in_parent).decompose()
    return TissueShape(
        name=empty.name,
        kind=settings.kind,
        origin_bone=origin_bone,
        insertion_bone=insertion_bone,
        centre=centre,
        rotation=rotation,
        semi_axes=semi_axes,
        origin_tendon=evaluated.origin_tendon if is_muscle else 0.0,
        insertion_tendon=evaluated.insertion_tendon if is_muscle else 0.0,
        volume_keeping=evaluated.volume_keeping,
        via_points=_read_via_points(rig, vias_of(empty) if vias is None else vias, depsgraph) if is_muscle else (),
        wraps=_read_wraps(empty) if is_muscle else (),
        skin_thickness=settings.skin_thickness,
    )


def vias_of(muscle) -> list:
    """The Empties of a muscle's via points in order. Searches the whole file."""
    return vias_by_muscle(filter(is_via, bpy.data.objects)).get(muscle.name_full, [])


def vias_by_muscle(vias) -> dict[str, list]:
    """The Empties of via points in order, by the full names of their muscles. Deleted ones are left out."""
    by_muscle: dict[str, list] = {}
    for via in vias:
        if via.sinew.tissue.muscle and is_used(via):
            by_muscle.setdefault(via.sinew.tissue.muscle.name_full, []).append(via)
    for of_muscle in by_muscle.values():
        of_muscle.sort(key=lambda via: (via.sinew.tissue.order, via.name))
    return by_muscle


def _read_via_points(rig, vias: list, depsgraph) -> tuple[tuple[str, Vector], ...]:
    points = []
    for via in vias:
        if via.parent != rig or via.parent_type != "BONE" or not bone_geometry.has_bone(rig, via.parent_bone):
            raise SinewError(
                f"{via.name}: bone '{via.parent_bone}' is not in {rig.name}. "
                "Parent the via point to a bone of it, or delete it"
            )
        location = (animated_value.values_of(via, depsgraph) if depsgraph else via).location
        points.append((via.parent_bone, rest_parent(via, rig) @ location))
    return tuple(points)


def _read_wraps(empty) -> tuple[str, ...]:
    # deleted spheres are ignored
    spheres = [wrap.sphere for wrap in empty.sinew.tissue.wraps if wrap.sphere and is_used(wrap.sphere)]
    for sphere in spheres:
        if not is_tissue(sphere) or sphere.sinew.tissue.kind != "SPHERE" or sphere.parent != empty.parent:
            raise SinewError(
                f"{empty.name}: wraps around {sphere.name}, which is not a sphere of {empty.parent.name}. "
                "Wrap another sphere"
            )
    return tuple(dict.fromkeys(sphere.name for sphere in spheres))


def rest_parent(empty, rig) -> Matrix:
    """The matrix from the space of an Empty's location, rotation and scale to armature space, in the rest pose."""
    return bone_geometry.rest_tail(rig, empty.parent_bone) @ empty.matrix_parent_inverse


def create(rig, shape: TissueShape, collection):
    """Creates the Empty of a tissue as a child of its origin bone, in `collection`, and the Empties of its via points.

    Spheres that the tissue wraps around must exist already, or be given to `write_wraps` later. Returns the Empty.
    """
    empty = bpy.data.objects.new(shape.name, None)
    collection.objects.link(empty)
    empty.empty_display_type = "SPHERE"
    empty.empty_display_size = 1.0
    _parent_to_bone(empty, rig, shape.origin_bone)
    empty.sinew.tissue.kind = shape.kind
    empty.sinew.tissue.name_in_files = shape.name
    write(empty, shape, [])
    return empty


def _parent_to_bone(empty, rig, bone: str):
    empty.parent = rig
    empty.parent_type = "BONE"
    empty.parent_bone = bone
    # with this inverse, location, rotation and scale of the Empty are in armature space
    empty.matrix_parent_inverse = bone_geometry.rest_tail(rig, bone).inverted()


def remove(empty, vias: list | None = None):
    """Removes the Empty of a tissue and those of its via points. vias: as for `read`."""
    for via in vias_of(empty) if vias is None else vias:
        discard(via)
    discard(empty)


def discard(empty):
    """Removes an Empty, and its action (such as keys of the tension) unless something else uses it."""
    action = empty.animation_data.action if empty.animation_data else None
    bpy.data.objects.remove(empty)
    if action and action.users == 0:
        bpy.data.actions.remove(action)


def write(empty, shape: TissueShape, vias: list | None = None):
    """Gives an Empty the transforms and settings of `shape`, and a muscle its via points and wraps.

    vias: as for `read`.
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
    settings = empty.sinew.tissue
    settings.insertion_bone = shape.insertion_bone if shape.kind == "MUSCLE" else ""
    settings.origin_tendon = shape.origin_tendon
    settings.insertion_tendon = shape.insertion_tendon
    settings.volume_keeping = shape.volume_keeping
    settings.skin_thickness = shape.skin_thickness
    if shape.kind == "MUSCLE":
        _write_via_points(empty, shape, vias_of(empty) if vias is None else vias)
        if _read_wraps(empty) != shape.wraps:
            tissues = {
                tissue.name: tissue for tissue in bpy.data.objects if tissue.parent == empty.parent and is_tissue(tissue)
            }
            write_wraps(empty, [tissues[name] for name in shape.wraps if name in tissues])


def _euler_of(rotation: Quaternion, order: str) -> Euler:
    """The Euler angles of a rotation, exact to rounding even where the middle angle is near 90 degrees.

    There Blender computes the two outer angles from tiny numbers with separate rounding errors. The last angle is corrected
    by the rotation that is missing.
    """
    angles = rotation.to_euler(order)
    error = rotation @ angles.to_quaternion().inverted()
    last = "XYZ".index(order[-1])
    angles[last] += 2.0 * (error.x, error.y, error.z)[last] * (1.0 if error.w >= 0.0 else -1.0)
    return angles


def write_wraps(empty, spheres: list):
    """Makes a muscle wrap around the spheres of these Empties, and no others."""
    wraps = empty.sinew.tissue.wraps
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
                _parent_to_bone(via, empty.parent, bone)
            via.sinew.tissue.order = order
            location = rest_parent(via, empty.parent).inverted() @ point
            if (via.location - location).length > SAME_POSITION_M:  # rounding must not move an unchanged via point
                via.location = location
        else:
            add_via(empty, bone, point, order)


def add_via(muscle, bone: str, point: Vector, order: int):
    """Creates the Empty of a via point of `muscle`, at a point in the rest pose (armature space). Returns it."""
    rig = muscle.parent
    via = bpy.data.objects.new(f"{muscle.name} via", None)
    editable_collections_of(muscle)[0].objects.link(via)
    via.empty_display_type = "PLAIN_AXES"
    via.empty_display_size = VIA_SIZE_OF_BELLY * abs(muscle.scale.z) * muscle.empty_display_size
    _parent_to_bone(via, rig, bone)
    via.location = point
    via.sinew.tissue.kind = "VIA"
    via.sinew.tissue.muscle = muscle
    via.sinew.tissue.order = order
    return via
