# SPDX-License-Identifier: GPL-3.0-or-later
"""Muscles for any joint, without a preset: flexor, extensor, abductor and adductor (Wilhelms 1997, section 4).

Each muscle runs from a point on the upper bone to a point on the lower bone, at a distance gamma from both. The flexor is on
the side that the joint bends to, the extensor on the opposite side, the other two at right angles to them. This works for
any animal or robot, joint by joint.
"""

from collections.abc import Collection, Iterator
from dataclasses import dataclass

import bpy
from bpy.types import Bone, Object
from mathutils import Vector

from ....scene.rig_pose import size_of
from ....scene.skinned_bones import SkinnedBones
from ....scene.tissue_empty import TissueShape
from ...axes import axes_along
from ..fit import fit
from ..fit.skin_surface import SkinSurface
from .joints import Joint, joints
from .single import MUSCLE_WIDTH_OF_LENGTH, TENDON_OF_LENGTH

KINDS = ("FLEXOR", "EXTENSOR", "ABDUCTOR", "ADDUCTOR")
STRAIGHT_COSINE = 0.996  # 5 degrees: a smaller rest bend does not show the direction that a joint bends to
MIDDLE_OF_SIZE = 0.005  # distance from the middle plane, as a fraction of the rig's size, that counts as in the middle
SHORTEST_LINE_M = 1e-6


@dataclass(frozen=True)
class Options:
    """How automatic muscles are made.

    kinds: of KINDS. along: fraction of each bone's length, from its head. gamma: distance from each bone, as a fraction of
    its length. shortest_m: shorter bones get no muscles; 0 chooses a limit by the size of the rig.
    """

    kinds: Collection[str] = KINDS
    along: float = 0.1
    gamma: float = 0.12
    shortest_m: float = 0.0
    fit_skin: bool = True


def on_joints(
    rig: Object, bones: Collection[str] | None, skins: list[Object], skinned: SkinnedBones, options: Options
) -> tuple[list[TissueShape], int]:
    """The muscles of all joints between these bones and the bones above them, fitted under a mesh, and the number of joints.

    bones: None means all that can hold muscles. skins: the meshes that they are fitted under. skinned: what the rig's meshes
    show. Raises SinewError as `SkinSurface.of_all` does.
    """
    surface = SkinSurface.of_all(skins, rig) if skins else None
    found = joints(rig, bones, options.shortest_m, skinned.weights, surface)
    shapes = [shape for joint in found for shape in muscles(rig, joint, options.kinds, options.along, options.gamma)]
    return (fit.fit_all(shapes, surface) if surface and options.fit_skin else shapes), len(found)


def muscles(rig: Object, joint: Joint, kinds: Collection[str], along: float, gamma: float) -> Iterator[TissueShape]:
    """The muscles of one joint, in armature space. Muscles whose attachments are the same point are left out.

    kinds: of KINDS. along: fraction of each bone's length, from its head. gamma: distance from each bone, as a fraction
    of its length.
    """
    front, side = _frame(joint)
    middle_m = MIDDLE_OF_SIZE * size_of(rig)
    outward = _outward(joint, side, middle_m)
    for kind in KINDS:
        if kind not in kinds:
            continue
        direction = {"FLEXOR": front, "EXTENSOR": -front, "ABDUCTOR": outward, "ADDUCTOR": -outward}[kind]
        shape = _muscle(_name(kind, joint, direction, middle_m), joint, direction, along, gamma)
        if shape is not None:
            yield shape


def _line(bone: Bone, end: Vector) -> Vector:
    return end - bone.head_local


def _frame(joint: Joint) -> tuple[Vector, Vector]:
    """(direction that the joint bends to, hinge axis): from the bend at rest, else from the lower bone's axes."""
    upper = _line(joint.upper, joint.upper_end).normalized()
    lower = _line(joint.lower, joint.lower_end).normalized()
    if upper.dot(lower) < STRAIGHT_COSINE:
        hinge = upper.cross(lower)
        if hinge.length > 1e-3:
            hinge.normalize()
            return hinge.cross(lower).normalized(), hinge
    axes = joint.lower.matrix_local.to_3x3()
    front, side = (axes.col[index].normalized() for index in (2, 0))
    front -= lower * front.dot(lower)  # the bone may run to the next joint, not along its own axis
    if front.length < 0.1:
        front = side - lower * side.dot(lower)
    front.normalize()
    return front, lower.cross(front)


def _outward(joint: Joint, side: Vector, middle_m: float) -> Vector:
    """The direction of the hinge that points away from the middle of the body; to the left for a joint in the middle."""
    sign = -1.0 if joint.lower.head_local.dot(joint.left) < -middle_m else 1.0
    return side if side.dot(joint.left) * sign >= 0.0 else -side


def _name(kind: str, joint: Joint, direction: Vector, middle_m: float) -> str:
    """The muscle's name, after the bone that it moves. The two lateral muscles of a central bone are a left-right pair."""
    lower, sideways = joint.lower, direction.dot(joint.left)
    is_sided = bpy.utils.flip_name(lower.name) != lower.name
    is_central = max(abs(point.dot(joint.left)) for point in (lower.head_local, joint.lower_end)) < middle_m
    if kind in ("ABDUCTOR", "ADDUCTOR") and is_central and not is_sided and abs(sideways) > 0.5:
        return f"Abductor {lower.name}.{'L' if sideways > 0 else 'R'}"
    return f"{kind.capitalize()} {lower.name}"


def _muscle(name: str, joint: Joint, direction: Vector, along: float, gamma: float) -> TissueShape | None:
    origin, insertion = (
        bone.head_local.lerp(end, along) + direction * (gamma * _line(bone, end).length)
        for bone, end in ((joint.upper, joint.upper_end), (joint.lower, joint.lower_end))
    )
    length_m = (insertion - origin).length
    if length_m < SHORTEST_LINE_M:
        return None
    line = (insertion - origin) / length_m

    width_m, tendon_m = MUSCLE_WIDTH_OF_LENGTH * length_m, TENDON_OF_LENGTH * length_m
    return TissueShape(
        name=name,
        kind="MUSCLE",
        origin_bone=joint.upper.name,
        insertion_bone=joint.lower.name,
        centre=(origin + insertion) / 2,
        rotation=axes_along(line, direction).to_quaternion(),
        semi_axes=Vector((width_m, width_m, length_m / 2 - tendon_m)),
        origin_tendon=tendon_m,
        insertion_tendon=tendon_m,
    )
