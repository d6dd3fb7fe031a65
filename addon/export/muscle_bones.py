# SPDX-License-Identifier: GPL-3.0-or-later
"""Muscles as bones of an armature, that stretch as bellies do by Blender's own constraints, without Sinew (ALGORITHM 2 and 11).

A muscle's bone has its head in the belly's centre, its Y along the belly and its X as the belly's x axis, so that its posed scale
is the belly's posed over rest semi-axes: `(x, z, y)`. Of Blender's Stretch To, with rest length m0 (the belly's) and bulge p,

    scale Y = d / m0,  scale X and Z = (m0 / d)^(p/2)

is our law where d = m, the belly's posed length. The belly's own ends lie on no bone, so two helpers that do not deform stand in:
one at the muscle's origin, and one at its insertion that points to the origin and is as long as both tendons together; its tail
is |path| - tendons = m from the origin, in every pose. In the order of the constraints, the muscle's bone

1. takes the mean of what the origin's and the insertion's bones do, linearly (Armature), and no size from it (Limit Scale): its X
   is then the mean of the rest x axis as the two carry it;
2. goes to the origin (Copy Location) and stretches to the helper's tail, keeping X as far as that goes (Stretch To);
3. goes back to the belly's centre, a constant share of the path from origin to insertion (Copy Location, by its influence);
4. thickens as the muscle is tense, by the scale that the helper at the origin is given (Copy Scale).

What none of these can do: paths that bend (via points, wraps), the floor under a belly shorter than a fifth of its rest length, and
the scale of scaled bones. There, keys on the bone's own location, rotation and scale say the same (`keyed`).
"""

from dataclasses import dataclass

import bpy
from mathutils import Matrix, Vector

from ..scene.tissue_empty import TissueShape

_COLLECTION, _HELPERS = "Muscles", "Muscle Helpers"
_SHORTEST_M = 1e-4
_NO_TENDON = 1e-6  # of the belly's length


@dataclass(frozen=True)
class MuscleBone:
    """A muscle and the bone that stands for it; `origin` and `insertion` are its helpers, empty where it is keyed."""

    shape: TissueShape
    bone: str
    origin: str = ""
    insertion: str = ""

    @property
    def is_keyed(self) -> bool:
        return not self.origin


def can_stretch(shape: TissueShape) -> bool:
    """Whether Stretch To gives this muscle's law: its path is straight."""
    return not shape.via_points and not shape.wraps


def build(rig, shapes: list[TissueShape], keyed: bool) -> list[MuscleBone]:
    """Adds a bone for each muscle to an armature, which must be the active object in Object Mode, and what stretches it.

    keyed: no constraints and helpers for any of them; the bones wait for keys.
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
    turned = shape.rotation.to_matrix()
    along = turned.col[2]
    axes = Matrix((turned.col[0], along, -turned.col[1])).transposed()
    own = _add_bone(bones, f"muscle {shape.name}", shape.origin_bone, shape.centre, axes, shape.semi_axes.z)
    if keyed:
        return MuscleBone(shape, own.name)
    origin = _add_bone(bones, f"origin {shape.name}", shape.origin_bone, shape.origin, axes, 0.5 * shape.semi_axes.z)
    back = Matrix((axes.col[0], -axes.col[1], -axes.col[2])).transposed()
    length = shape.origin_tendon + shape.insertion_tendon
    end = shape.centre + along * (shape.semi_axes.z + shape.insertion_tendon)
    insertion = _add_bone(bones, f"insertion {shape.name}", shape.insertion_bone, end, back, length)
    return MuscleBone(shape, own.name, origin.name, insertion.name)


def _add_bone(bones, name: str, parent: str, head: Vector, axes: Matrix, length: float):
    """A new edit bone; Blender shortens a name that is too long and numbers one that is taken."""
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
