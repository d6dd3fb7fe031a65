# SPDX-License-Identifier: GPL-3.0-or-later
"""Turns muscles into bones that Blender's constraints stretch and thicken like the bellies, without Sinew.

The head of a muscle's bone is the belly's centre, its Y axis is the axis of the belly and its X axis the belly's x
axis. So its posed scale is the belly's posed semi-axes divided by its rest semi-axes, (x, z, y). Blender's Stretch To,
with rest length m0 (the belly's) and bulge p, gives

    scale Y = d / m0,  scale X and Z = (m0 / d)^(p/2)

which is the law of the muscle (docs/mathematics/baking.md, Muscle bones) where d = m, the belly's posed length. The
ends of the belly are not on bones. So there are two helper bones, which do not deform: one at the muscle's origin, and
one at its insertion that points to the origin and is as long as both tendons together. The distance of its tail from
the origin is |path| - tendons = m in every pose. In the order of its constraints, the muscle's bone

1. takes the linear mean of the transforms of the origin's and the insertion's bones (Armature) without their scale
   (Limit Scale): its X axis becomes the mean of the rest x axis moved with each of the two;
2. moves to the origin (Copy Location) and stretches to the helper's tail, keeping X as far as possible (Stretch To);
3. moves back to the belly's centre, a constant fraction of the path from origin to insertion (Copy Location, by its
   influence);
4. thickens with tension, by the scale of the helper at the origin (Copy Scale).

Constraints can't reproduce curved paths (via points, wraps), the minimum length of a belly, a fifth of its rest length,
and the scale of scaled bones. There, keyframes of the bone's location, rotation and scale do (`keyed`).
"""

from dataclasses import dataclass

import bpy
from mathutils import Matrix, Vector

from ..scene.tissue_empty import TissueShape

_COLLECTION, _HELPERS = "Muscles", "Muscle Helpers"
_SHORTEST_M = 1e-4
_NO_TENDON = 1e-6  # relative to the belly's length


@dataclass(frozen=True)
class MuscleBone:
    """A muscle, its bone, and its helper bones `origin` and `insertion`, which are empty if it is keyed."""

    shape: TissueShape
    bone: str
    origin: str = ""
    insertion: str = ""

    @property
    def is_keyed(self) -> bool:
        return not self.origin


def can_stretch(shape: TissueShape) -> bool:
    """Whether Stretch To reproduces the muscle, which is so if its path is straight."""
    return not shape.via_points and not shape.wraps


def build(rig, shapes: list[TissueShape], keyed: bool) -> list[MuscleBone]:
    """Adds a bone for each muscle to an armature, with helpers and constraints.

    rig: must be the active object, in Object Mode. keyed: add no helpers and constraints, since all bones will get
    keyframes.
    """
    bpy.ops.object.mode_set(mode="EDIT")
    made = [_add(rig.data.edit_bones, shape, keyed or not can_stretch(shape)) for shape in shapes]
    bpy.ops.object.mode_set(mode="OBJECT")
    for bone in made:
        data = rig.data.bones[bone.bone]
        data.use_deform = True
        _collect(rig, _COLLECTION, data, shown=True)
        rig.pose.bones[bone.bone].rotation_mode = "QUATERNION"
        if not bone.is_keyed:
            data.use_inherit_rotation, data.inherit_scale = False, "NONE"
            for helper in (bone.origin, bone.insertion):
                rig.data.bones[helper].use_deform = False
                _collect(rig, _HELPERS, rig.data.bones[helper], shown=False)
            _constrain(rig, bone)
    return made


def _add(bones, shape: TissueShape, keyed: bool) -> MuscleBone:
    belly = shape.rotation.to_matrix()
    along = belly.col[2]
    axes = Matrix((belly.col[0], along, -belly.col[1])).transposed()
    muscle = _add_bone(bones, f"muscle {shape.name}", shape.origin_bone, shape.centre, axes, shape.semi_axes.z)
    if keyed:
        return MuscleBone(shape, muscle.name)
    origin = _add_bone(bones, f"origin {shape.name}", shape.origin_bone, shape.origin, axes, 0.5 * shape.semi_axes.z)
    back = Matrix((axes.col[0], -axes.col[1], -axes.col[2])).transposed()
    length = shape.origin_tendon + shape.insertion_tendon
    end = shape.centre + along * (shape.semi_axes.z + shape.insertion_tendon)
    insertion = _add_bone(bones, f"insertion {shape.name}", shape.insertion_bone, end, back, length)
    return MuscleBone(shape, muscle.name, origin.name, insertion.name)


def _add_bone(bones, name: str, parent: str, head: Vector, axes: Matrix, length: float):
    """Adds an edit bone. Blender shortens a name that is too long and numbers a name that is taken."""
    bone = bones.new(name)
    bone.head, bone.tail = (0.0, 0.0, 0.0), (0.0, max(length, _SHORTEST_M), 0.0)
    bone.matrix = Matrix.Translation(head) @ axes.to_4x4()
    bone.parent = bones[parent]
    bone.use_connect = False
    return bone


def _collect(rig, name: str, bone, shown: bool):
    collections = rig.data.collections
    collection = collections.get(name)
    if collection is None:
        collection = collections.new(name)
        collection.is_visible = shown
    collection.assign(bone)


def _constrain(rig, bone: MuscleBone):
    shape, belly_m = bone.shape, 2.0 * bone.shape.semi_axes.z
    tendons_m = shape.origin_tendon + shape.insertion_tendon
    has_tendons = tendons_m > _NO_TENDON * belly_m
    if has_tendons:
        back = rig.pose.bones[bone.insertion].constraints.new("DAMPED_TRACK")
        back.target, back.subtarget, back.track_axis = rig, bone.origin, "TRACK_Y"

    constraints = rig.pose.bones[bone.bone].constraints
    mean = constraints.new("ARMATURE")
    for carrier in (shape.origin_bone, shape.insertion_bone):
        target = mean.targets.new()
        target.target, target.subtarget, target.weight = rig, carrier, 0.5
    size = constraints.new("LIMIT_SCALE")
    size.owner_space = "POSE"
    for axis in "xyz":
        for end in ("min", "max"):
            setattr(size, f"use_{end}_{axis}", True)
            setattr(size, f"{end}_{axis}", 1.0)
    start = constraints.new("COPY_LOCATION")
    start.target, start.subtarget = rig, bone.origin
    stretch = constraints.new("STRETCH_TO")
    stretch.target, stretch.subtarget = rig, bone.insertion
    stretch.head_tail = 1.0 if has_tendons else 0.0
    stretch.rest_length = belly_m
    stretch.bulge, stretch.volume, stretch.keep_axis = shape.volume_keeping, "VOLUME_XZX", "PLANE_X"
    centre = constraints.new("COPY_LOCATION")
    centre.target, centre.subtarget = rig, bone.insertion
    centre.influence = (shape.origin_tendon + 0.5 * belly_m) / (belly_m + tendons_m)
    tense = constraints.new("COPY_SCALE")
    tense.target, tense.subtarget = rig, bone.origin
    tense.use_offset, tense.target_space, tense.owner_space = True, "LOCAL", "POSE"
