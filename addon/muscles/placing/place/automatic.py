# SPDX-License-Identifier: GPL-3.0-or-later
"""Muscles for a joint that nobody described: flexor, extensor, abductor and adductor (Wilhelms 1997, sec. 4).

Each runs from a point on the upper bone to one just beyond the joint on the lower, beside the bones by gamma: the flexor
where the joint bends to, the extensor opposite, the other two square to them. A fish, a horse or a robot gets muscles
joint by joint.
"""

from collections.abc import Collection, Iterator
from dataclasses import dataclass

import bpy
from bpy.types import Bone, Object
from mathutils import Matrix, Vector

from ....scene.tissue_empty import TissueShape
from .single import MUSCLE_WIDTH_OF_LENGTH, TENDON_OF_LENGTH

KINDS = ("FLEXOR", "EXTENSOR", "ABDUCTOR", "ADDUCTOR")
STRAIGHT_COSINE = 0.996  # 5 degrees: a joint bent less at rest doesn't tell where it bends to
MIDDLE_OF_SIZE = 0.005
SHORTEST_OF_SIZE = 0.03
SHORTEST_LINE_M = 1e-6


@dataclass(frozen=True)
class Joint:
    """Two bones that meet."""

    upper: Bone
    lower: Bone


def size_of(rig: Object) -> float:
    """The largest extent of a rig's bones, armature space, metres."""
    ends = [end for bone in rig.data.bones for end in (bone.head_local, bone.tail_local)]
    return max((max(end[axis] for end in ends) - min(end[axis] for end in ends) for axis in range(3)), default=0.0)


def joints(rig: Object, bones: Collection[str] | None, shortest_m: float) -> list[Joint]:
    """The joints of these bones with the bones above them; of all bones where `bones` is None.

    Where a rig has deform bones, only they count. shortest_m: bones shorter than that have no muscles; 0 leaves out what
    is small for the rig (fingers, a face).
    """
    everything = rig.data.bones
    deforming = any(bone.use_deform for bone in everything)
    shortest_m = shortest_m or SHORTEST_OF_SIZE * size_of(rig)

    def counts(bone: Bone) -> bool:
        return (bone.use_deform or not deforming) and bone.length >= shortest_m

    def above(bone: Bone) -> Bone | None:
        return next((upper for upper in bone.parent_recursive if counts(upper)), None)

    wanted = [bone for bone in everything if counts(bone) and (bones is None or bone.name in bones)]
    return [Joint(upper, bone) for bone in wanted if (upper := above(bone)) is not None]


def muscles(rig: Object, joint: Joint, kinds: Collection[str], along: float, gamma: float) -> Iterator[TissueShape]:
    """The muscles of one joint, in armature space, without those whose attachments fall on one point.

    along: share of each bone's length from its head. gamma: distance from the bones, as a share of each one's length.
    """
    front, side = _frame(joint)
    middle_m = MIDDLE_OF_SIZE * size_of(rig)
    outward = _outward(joint, side, middle_m)
    for kind in KINDS:
        if kind not in kinds:
            continue
        direction = {"FLEXOR": front, "EXTENSOR": -front, "ABDUCTOR": outward, "ADDUCTOR": -outward}[kind]
        shape = _muscle(_name(kind, joint.lower, direction, middle_m), joint, direction, along, gamma)
        if shape is not None:
            yield shape


def _direction(bone: Bone) -> Vector:
    return (bone.tail_local - bone.head_local).normalized()


def _frame(joint: Joint) -> tuple[Vector, Vector]:
    """(where the joint bends to, its hinge): from the bend at rest, else from the lower bone's own axes."""
    upper, lower = _direction(joint.upper), _direction(joint.lower)
    if upper.dot(lower) < STRAIGHT_COSINE:
        hinge = upper.cross(lower)
        if hinge.length > 1e-3:
            hinge.normalize()
            return hinge.cross(lower).normalized(), hinge
    axes = joint.lower.matrix_local.to_3x3()
    return axes.col[2].normalized(), axes.col[0].normalized()


def _outward(joint: Joint, side: Vector, middle_m: float) -> Vector:
    """The hinge's end that looks away from the middle of the body; of a joint in the middle, its left."""
    at = joint.lower.head_local.x
    wanted = -1.0 if at < -middle_m else 1.0
    return side if side.x * wanted >= 0.0 else -side


def _name(kind: str, lower: Bone, direction: Vector, middle_m: float) -> str:
    """After the bone that it moves; in the middle of the body the two at its sides are a pair, left and right."""
    is_sided = bpy.utils.flip_name(lower.name) != lower.name
    lies_in_middle = max(abs(lower.head_local.x), abs(lower.tail_local.x)) < middle_m
    if kind in ("ABDUCTOR", "ADDUCTOR") and lies_in_middle and not is_sided and abs(direction.x) > 0.5:
        return f"Abductor {lower.name}.{'L' if direction.x > 0 else 'R'}"
    return f"{kind.capitalize()} {lower.name}"


def _muscle(name: str, joint: Joint, direction: Vector, along: float, gamma: float) -> TissueShape | None:
    origin, insertion = (
        bone.head_local.lerp(bone.tail_local, along) + direction * (gamma * bone.length)
        for bone in (joint.upper, joint.lower)
    )
    length_m = (insertion - origin).length
    if length_m < SHORTEST_LINE_M:
        return None
    line = (insertion - origin) / length_m
    x = direction - line * direction.dot(line)
    x = x.normalized() if x.length > 1e-3 else line.orthogonal().normalized()
    width_m, tendon_m = MUSCLE_WIDTH_OF_LENGTH * length_m, TENDON_OF_LENGTH * length_m
    return TissueShape(
        name=name,
        kind="MUSCLE",
        origin_bone=joint.upper.name,
        insertion_bone=joint.lower.name,
        centre=(origin + insertion) / 2,
        rotation=Matrix((x, line.cross(x), line)).transposed().to_quaternion(),
        semi_axes=Vector((width_m, width_m, length_m / 2 - tendon_m)),
        origin_tendon=tendon_m,
        insertion_tendon=tendon_m,
    )
