# SPDX-License-Identifier: GPL-3.0-or-later
"""A copy of a rig, to be posed where nobody sees it: the character itself, its keys and its pose stay as they are.

The copy keeps the rig's constraints and drivers, turned to itself, so that a twist bone follows a hand as it does on the
character. It has none of them where a joint that is asked for is itself turned by a constraint, as the deform bones of a
generated rig are, or where they hold the rig off its rest pose: then each bone turns by itself, and its children with it.
"""

import bpy
import numpy as np

from ...errors import SinewError
from ...reach import bone_limits
from .joint_turns import Motion, rotation_of

_AT_REST = 1e-4


class ScratchRig:
    """One copy. `remove` takes it away."""

    def __init__(self, scene, rig, bones: list[str]):
        """bones: the joints that will be turned."""
        self._copy, self._turned = "", []
        follows = bone_limits.driven_bones(rig).isdisjoint(bones)
        self._add(scene, rig, bones if follows else None)
        if follows and not self._is_at_rest():
            self.remove()
            self._add(scene, rig, None)

    def _add(self, scene, rig, followed: list[str] | None):
        """Adds the copy; with the rig's constraints where bones are followed."""
        copy = bpy.data.objects.new(rig.name, rig.data) if followed is None else rig.copy()
        copy.name = f"{rig.name} baking"
        self._copy = copy.name
        scene.collection.objects.link(copy)
        # what is hidden is not evaluated
        copy.display_type = "BOUNDS"
        copy.hide_viewport = False
        copy.hide_select = copy.hide_render = True
        if followed is not None:
            _turn_to_itself(copy, rig)
            for bone in copy.pose.bones:
                bone.matrix_basis.identity()
            for name in followed:
                for constraint in copy.pose.bones[name].constraints:
                    constraint.mute = True  # what is left there are limits; how far a joint turns was decided before
        bpy.context.view_layer.update()

    def posed(self, turns: list[tuple[Motion, float]]):
        """The copy, evaluated, with joints turned so and all others at rest."""
        copy = bpy.data.objects.get(self._copy)
        if copy is None:
            raise SinewError("the armature that is posed for the bake was deleted meanwhile: bake again")
        for name in self._turned:
            copy.pose.bones[name].rotation_quaternion.identity()
        self._turned = list(dict.fromkeys(motion.bone for motion, _ in turns))
        for name in self._turned:
            bone = copy.pose.bones[name]
            bone.rotation_mode = "QUATERNION"
            bone.rotation_quaternion = rotation_of([turn for turn in turns if turn[0].bone == name])
        bpy.context.view_layer.update()
        return copy.evaluated_get(bpy.context.evaluated_depsgraph_get())

    def remove(self):
        """Takes the copy away."""
        copy = bpy.data.objects.get(self._copy)
        if copy:
            bpy.data.objects.remove(copy)

    def _is_at_rest(self) -> bool:
        bones = self.posed([]).pose.bones
        rest, now = (
            np.array(matrices) for matrices in zip(*((bone.bone.matrix_local, bone.matrix) for bone in bones), strict=True)
        )
        return bool(np.abs(now - rest).max() < _AT_REST * max(1.0, np.abs(rest).max()))


def _turn_to_itself(copy, rig):
    """Lets constraints and drivers of a copied rig look at the copy where they looked at the rig; its keys are left out."""
    for bone in copy.pose.bones:
        for constraint in bone.constraints:
            for name in ("target", "pole_target"):
                if getattr(constraint, name, None) == rig:
                    setattr(constraint, name, copy)
            for target in getattr(constraint, "targets", ()):
                if target.target == rig:
                    target.target = copy
    animation = copy.animation_data
    if animation:
        animation.action = None
        for track in list(animation.nla_tracks):
            animation.nla_tracks.remove(track)
        for curve in animation.drivers:
            for variable in curve.driver.variables:
                for target in variable.targets:
                    if target.id == rig:
                        target.id = copy
