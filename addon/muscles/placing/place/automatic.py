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
from ....scene.tissue_empty import TissueShape
from ...axes import axes_along
from .single import MUSCLE_WIDTH_OF_LENGTH, TENDON_OF_LENGTH

KINDS = ("FLEXOR", "EXTENSOR", "ABDUCTOR", "ADDUCTOR")
STRAIGHT_COSINE = 0.996  # 5 degrees: a smaller rest bend does not show the direction that a joint bends to
MIDDLE_OF_SIZE = 0.005  # distance from the middle plane, as a fraction of the rig's size, that counts as in the middle
SHORTEST_OF_SIZE = 0.03  # length of the shortest bone with muscles, as a fraction of the rig's size
SHORTEST_LINE_M = 1e-6


@dataclass(frozen=True)
class Joint:
    """A bone and the nearest bone above it that counts."""

    upper: Bone
    lower: Bone


def joints(rig: Object, bones: Collection[str] | None, shortest_m: float) -> list[Joint]:
    """The joints between these bones and the bones above them; None means all bones.

    If a rig has deform bones, only they count. shortest_m: shorter bones get no muscles; 0 chooses a limit from the rig's
    size that excludes fingers and faces.
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
        shape = _muscle(_name(kind, joint.lower, direction, middle_m), joint, direction, along, gamma)
        if shape is not None:
            yield shape


def _direction(bone: Bone) -> Vector:
    return (bone.tail_local - bone.head_local).normalized()


def _frame(joint: Joint) -> tuple[Vector, Vector]:
    """(direction that the joint bends to, hinge axis): from the bend at rest, else from the lower bone's axes."""
    upper, lower = _direction(joint.upper), _direction(joint.lower)
    if upper.dot(lower) < STRAIGHT_COSINE:
        hinge = upper.cross(lower)
        if hinge.length > 1e-3:
            hinge.normalize()
            return hinge.cross(lower).normalized(), hinge
    axes = joint.lower.matrix_local.to_3x3()
    return axes.col[2].normalized(), axes.col[0].normalized()


def _outward(joint: Joint, side: Vector, middle_m: float) -> Vector:
    """The direction of the hinge that points away from the middle of the body; to the left for a joint in the middle."""
    sign = -1.0 if joint.lower.head_local.x < -middle_m else 1.0
    return side if side.x * sign >= 0.0 else -side


def _name(kind: str, lower: Bone, direction: Vector, middle_m: float) -> str:
    """The muscle's name, after the bone that it moves. The two lateral muscles of a central bone are a left-right pair."""
    is_sided = bpy.utils.flip_name(lower.name) != lower.name
    is_central = max(abs(lower.head_local.x), abs(lower.tail_local.x)) < middle_m
    if kind in ("ABDUCTOR", "ADDUCTOR") and is_central and not is_sided and abs(direction.x) > 0.5:
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
