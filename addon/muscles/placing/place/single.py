# SPDX-License-Identifier: GPL-3.0-or-later
"""One tissue on bones that the user chose, with default proportions (Wilhelms 1997, section 4)."""

from dataclasses import replace

from mathutils import Quaternion, Vector

from ....errors import SinewError
from ....scene import bone_geometry
from ....scene.tissue_empty import TissueShape
from ...axes import axes_along, perpendicular

TENDON_OF_LENGTH = 0.1
MUSCLE_WIDTH_OF_LENGTH = 0.09
RIGID_WIDTH_OF_LENGTH = {"BONE": 0.08, "STUFFING": 0.3, "SPHERE": 0.15}
_LABELS = {"MUSCLE": "Muscle", "BONE": "Bone", "STUFFING": "Stuffing", "SPHERE": "Sphere"}


def muscle(rig, origin_bone: str, insertion_bone: str, along: float, around: float, offset: float) -> TissueShape:
    """A muscle from a point on one bone to a point on another, in armature space.

    along: fraction of each bone's length, from its head. around: rotation about the muscle's line in radians, from the
    origin bone's local z. offset: distance of both points from the bones, as a fraction of the muscle's length. Raises
    SinewError if both points are the same.
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
    aside = perpendicular(direction, bone_geometry.rest_axis(rig, origin_bone, 2))
    aside = Quaternion(direction, around) @ aside
    tendon = TENDON_OF_LENGTH * length
    width = MUSCLE_WIDTH_OF_LENGTH * length
    return TissueShape(
        name=f"{_LABELS['MUSCLE']} {insertion_bone}",
        kind="MUSCLE",
        origin_bone=origin_bone,
        insertion_bone=insertion_bone,
        centre=(origin + insertion) / 2 + aside * offset * length,
        rotation=axes_along(direction, aside).to_quaternion(),
        semi_axes=Vector((width, width, length / 2 - tendon)),
        origin_tendon=tendon,
        insertion_tendon=tendon,
    )


def rigid(rig, kind: str, bone: str) -> TissueShape:
    """A rigid tissue in armature space: a bone tissue or stuffing along a bone, or a sphere at its head."""
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
        rotation=axes_along((tail - head) / length, bone_geometry.rest_axis(rig, bone, 0)).to_quaternion(),
        semi_axes=Vector((width, width, width if is_sphere else length / 2)),
    )


def renamed(shape: TissueShape, name: str) -> TissueShape:
    """The same tissue with another name."""
    return replace(shape, name=name)
