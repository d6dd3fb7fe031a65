# SPDX-License-Identifier: GPL-3.0-or-later
"""A temporary copy of a rig in the scene, posed joint by joint while the character keeps its pose and animation.

It is a Blender object, and Blender evaluates its pose. (`export.copy_pose` is another thing: it computes the pose
matrices of an export copy from those of the character and changes no object.)

The copy keeps the rig's constraints and drivers, with itself as their target, so that a twist bone follows a hand as it
does on the character. In two cases the copy has no constraints, and each bone rotates by itself together with its
children: if a joint to turn is driven by a constraint, like the deform bones of a generated rig, or if the constraints
hold the rig out of its rest pose.
"""

import bpy
import numpy as np

from ...errors import SinewError
from ...reach import bone_limits
from ...scene.retarget import retarget_constraint, retarget_drivers
from .joint_turns import TurnAngles, rotation_of

_AT_REST = 1e-4  # relative to the largest entry of the rest matrices


class ScratchRig:
    """One copy of a rig. `remove` deletes it."""

    def __init__(self, scene, rig, bones: list[str]):
        """bones: those that `posed` may rotate."""
        self._copy, self._rotated = "", []
        follows = bone_limits.driven_bones(rig).isdisjoint(bones)
        self._add(scene, rig, bones if follows else None)
        if follows and not self._is_at_rest():
            self.remove()
            self._add(scene, rig, None)

    def _add(self, scene, rig, joints: list[str] | None):
        """Adds the copy. joints: the bones to rotate, if the copy keeps the rig's constraints; None: without constraints."""
        copy = bpy.data.objects.new(rig.name, rig.data) if joints is None else rig.copy()
        copy.name = f"{rig.name} baking"
        self._copy = copy.name
        scene.collection.objects.link(copy)
        # Blender does not evaluate hidden objects.
        copy.display_type = "BOUNDS"
        copy.hide_viewport = False
        copy.hide_select = copy.hide_render = True
        if joints is not None:
            _refer_to_itself(copy, rig)
            for bone in copy.pose.bones:
                bone.matrix_basis.identity()
            for name in joints:
                for constraint in copy.pose.bones[name].constraints:
                    constraint.mute = True  # only limits are left there, and the range of the joint is already chosen
        bpy.context.view_layer.update()

    def posed(self, angles: TurnAngles):
        """Returns the evaluated copy with joints at these angles and all other joints at rest."""
        copy = bpy.data.objects.get(self._copy)
        if copy is None:
            raise SinewError("The armature that is posed for the bake was deleted during the bake: bake again")
        for name in self._rotated:
            copy.pose.bones[name].rotation_quaternion.identity()
        self._rotated = list(dict.fromkeys(turn.bone for turn, _ in angles))
        for name in self._rotated:
            bone = copy.pose.bones[name]
            bone.rotation_mode = "QUATERNION"
            bone.rotation_quaternion = rotation_of([each for each in angles if each[0].bone == name])
        bpy.context.view_layer.update()
        return copy.evaluated_get(bpy.context.evaluated_depsgraph_get())

    def remove(self):
        """Deletes the copy."""
        copy = bpy.data.objects.get(self._copy)
        if copy:
            bpy.data.objects.remove(copy)

    def _is_at_rest(self) -> bool:
        bones = self.posed([]).pose.bones
        rest, present = (
            np.array(matrices) for matrices in zip(*((bone.bone.matrix_local, bone.matrix) for bone in bones), strict=True)
        )
        return bool(np.abs(present - rest).max() < _AT_REST * max(1.0, np.abs(rest).max()))


def _refer_to_itself(copy, rig):
    """Makes a copied rig the target of its constraints and drivers, and removes its animation."""
    for bone in copy.pose.bones:
        for constraint in bone.constraints:
            retarget_constraint(constraint, rig, copy)
    retarget_drivers(copy, {rig: copy})
    animation = copy.animation_data
    if animation:
        animation.action = None
        for track in list(animation.nla_tracks):
            animation.nla_tracks.remove(track)
