# SPDX-License-Identifier: GPL-3.0-or-later
"""Which joints of a skeleton get automatic muscles, and where the bones of a joint run.

The tail of an imported bone points anywhere, so a bone runs to the next joint where it has one. A bone gets no muscles if it
is short, if it is thin against the body, if it carries no skin, or if its name says that it is a finger, a toe, hair,
clothes or a part of the face.
"""

from collections.abc import Collection, Mapping
from dataclasses import dataclass

from bpy.types import Bone, Object
from mathutils import Vector

from ....scene.rig_pose import size_of
from ..fit.skin_surface import SkinSurface
from ..recognise import names
from ..recognise.body_space import body_space
from ..recognise.name_words import LIMB_ENDS, Reading

SHORTEST_OF_SIZE = 0.03  # length of the shortest bone with muscles, as a fraction of the rig's size
# Distance from a bone to the skin, as a fraction of the largest of all bones, below which a bone is a finger, an ear or a
# feather: of a person's bones, fingers have 0.05 to 0.08, wrists 0.2.
THINNEST_OF_THICKEST = 0.1
TESTED = (0.25, 0.5, 0.75)  # positions along a bone where the distance to the skin is measured
FACE = ("head", "jaw")


@dataclass(frozen=True)
class Joint:
    """A bone and the nearest bone above it that counts.

    upper_end, lower_end: where each bone runs to. left: the unit vector to the left of the body. Armature space.
    """

    upper: Bone
    lower: Bone
    upper_end: Vector
    lower_end: Vector
    left: Vector


def joints(
    rig: Object,
    bones: Collection[str] | None,
    shortest_m: float,
    carrying: Mapping[str, float] | None = None,
    skin: SkinSurface | None = None,
) -> list[Joint]:
    """The joints between these bones and the bones above them; None means all bones that can hold muscles.

    If a rig has deform bones, only they count. shortest_m: shorter bones get no muscles; 0 chooses a limit from the
    rig's size that excludes fingers and faces. carrying: the weight of each bone that carries skin
    (`SkinnedBones.weights`). skin: the mesh that bones are measured against.
    """
    everything = rig.data.bones
    readings = names.readings_of(rig)
    left = Vector(body_space(rig, readings, list(everything)).to_body[0][:3]) if everything else Vector((1, 0, 0))
    deforming = any(bone.use_deform for bone in everything)
    shortest_m = shortest_m or SHORTEST_OF_SIZE * size_of(rig)
    ends = {bone: _end(bone) for bone in everything}
    counting = {
        bone
        for bone in everything
        if (bone.use_deform or not deforming) and (ends[bone] - bone.head_local).length >= shortest_m
    }
    if bones is None:
        wanted = _able(counting, ends, readings, carrying or {}, skin)
    else:
        wanted = {bone for bone in counting if bone.name in bones}
    found = []
    for bone in (bone for bone in everything if bone in wanted):
        upper = next(
            (upper for upper in bone.parent_recursive if upper in (counting if bones is not None else wanted)), None
        )
        if upper is None and bones is None:
            upper = next((upper for upper in bone.parent_recursive if upper in counting), None)
        if upper is not None:
            reach = bone.head_local - upper.head_local
            upper_end = bone.head_local.copy() if reach.length > shortest_m else ends[upper]
            found.append(Joint(upper, bone, upper_end, ends[bone], left))
    return found


def _end(bone: Bone) -> Vector:
    """Where a bone runs to: the head of the child that its tail points to best, or its tail if it has no child."""
    heads = [child.head_local for child in bone.children if (child.head_local - bone.head_local).length > 1e-6]
    along = bone.tail_local - bone.head_local
    if not heads:
        return bone.tail_local.copy()
    return max(heads, key=lambda head: (head - bone.head_local).normalized().dot(along)).copy()


def _able(
    counting: set[Bone],
    ends: Mapping[Bone, Vector],
    readings: Mapping[Bone, Reading],
    carrying: Mapping[str, float],
    skin: SkinSurface | None,
) -> set[Bone]:
    """The bones that can hold muscles."""
    heads = _heads(readings)
    able = {bone for bone in counting if _is_of_body(bone, readings, heads) and (not carrying or bone.name in carrying)}
    if skin is None:
        return able
    depths = {bone: _depth(bone, ends[bone], skin) for bone in able}
    thinnest = THINNEST_OF_THICKEST * max((depth for depth in depths.values() if depth is not None), default=0.0)
    return {bone for bone, depth in depths.items() if depth is None or depth >= thinnest}


def _heads(readings: Mapping[Bone, Reading]) -> set[Bone]:
    """The bones that hold a face, by name. A head that most bones of the rig follow is the front of a snake or fish."""
    named = [bone for bone, said in readings.items() if said.part in FACE and not said.other]
    return {bone for bone in named if 2 * len(bone.children_recursive) < len(readings)}


def _is_of_body(bone: Bone, readings: Mapping[Bone, Reading], heads: set[Bone]) -> bool:
    """Whether the names of a bone and of those above it do not say that it is a finger, a part of the face, or worn."""
    said = readings[bone]
    return not said.other and said.part not in LIMB_ENDS | {"toes"} and heads.isdisjoint(bone.parent_recursive)


def _depth(bone: Bone, end: Vector, skin: SkinSurface) -> float | None:
    """The largest distance from a bone to the skin around it; None if the bone is outside."""
    points = [bone.head_local.lerp(end, along) for along in TESTED]
    return max((skin.nearest_distance(point) for point in points if skin.is_inside(point)), default=None)
