# SPDX-License-Identifier: GPL-3.0-or-later
"""One tissue on given bones, in default proportions, where no preset says better (Wilhelms 1997, sec. 4)."""

from dataclasses import replace

from mathutils import Matrix, Quaternion, Vector

from ....errors import SinewError
from ....scene import bone_geometry
from ....scene.tissue_empty import TissueShape

TENDON_OF_LENGTH = 0.1
MUSCLE_WIDTH_OF_LENGTH = 0.09
RIGID_WIDTH_OF_LENGTH = {"BONE": 0.08, "STUFFING": 0.3, "SPHERE": 0.15}
_LABELS = {"MUSCLE": "Muscle", "BONE": "Bone", "STUFFING": "Stuffing", "SPHERE": "Sphere"}


def muscle(rig, origin_bone: str, insertion_bone: str, along: float, around: float, offset: float) -> TissueShape:
    """A muscle from a point on one bone to a point on another.

    along: share of each bone's length from its head. around: radians about the muscle's line, from the origin bone's
    local z. offset: distance of both points from the bones, as a share of the muscle's length.
    Raises SinewError where both points are the same.
    """
    origin, insertion = (
        bone_geometry.point_along(rig, origin_bone, along),
        bone_geometry.point_along(rig, insertion_bone, along),
    )
    line = insertion - origin
    length = line.length
    if length < 1e-6:
        raise SinewError(f"A muscle from '{origin_bone}' to '{insertion_bone}' has no length: choose another Along")
    direction = line / length
    aside = _perpendicular(bone_geometry.rest_axis(rig, origin_bone, 2), direction)
    aside = Quaternion(direction, around) @ aside
    tendon = TENDON_OF_LENGTH * length
    width = MUSCLE_WIDTH_OF_LENGTH * length
    return TissueShape(
        name=f"{_LABELS['MUSCLE']} {insertion_bone}",
        kind="MUSCLE",
        origin_bone=origin_bone,
        insertion_bone=insertion_bone,
        centre=(origin + insertion) / 2 + aside * offset * length,
        rotation=_rotation(aside, direction),
        semi_axes=Vector((width, width, length / 2 - tendon)),
        origin_tendon=tendon,
        insertion_tendon=tendon,
    )


def rigid(rig, kind: str, bone: str) -> TissueShape:
    """A bone or stuffing along a bone, or a sphere at its head."""
    head, tail = bone_geometry.point_along(rig, bone, 0.0), bone_geometry.point_along(rig, bone, 1.0)
    length = (tail - head).length
    width = RIGID_WIDTH_OF_LENGTH[kind] * length
    is_sphere = kind == "SPHERE"
    return TissueShape(
        name=f"{_LABELS[kind]} {bone}",
        kind=kind,
        origin_bone=bone,
        insertion_bone=bone,
        centre=head if is_sphere else (head + tail) / 2,
        rotation=_rotation(bone_geometry.rest_axis(rig, bone, 0), (tail - head) / length),
        semi_axes=Vector((width, width, width if is_sphere else length / 2)),
    )


def renamed(shape: TissueShape, name: str) -> TissueShape:
    """The same tissue under another name."""
    return replace(shape, name=name)


def _perpendicular(wanted: Vector, direction: Vector) -> Vector:
    aside = wanted - direction * wanted.dot(direction)
    return aside.normalized() if aside.length > 1e-3 else direction.orthogonal().normalized()


def _rotation(x_like: Vector, z: Vector) -> Quaternion:
    x = _perpendicular(x_like, z)
    return Matrix((x, z.cross(x), z)).transposed().to_quaternion()
