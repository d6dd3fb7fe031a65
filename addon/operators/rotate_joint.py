# SPDX-License-Identifier: GPL-3.0-or-later
"""`sinew.rotate_joint` rotates bones about a local axis, scaled by their eagerness."""

from bpy.props import EnumProperty, FloatProperty
from bpy.types import Operator

from ..errors import SinewError
from ..reach import bone_limits, keying
from .base import PoseModeOperator


class SINEW_OT_rotate_joint(PoseModeOperator, Operator):
    """Rotate the selected bones about a local axis, scaled by their eagerness and within their limits"""

    bl_idname, bl_label = "sinew.rotate_joint", "Rotate Joint"

    axis: EnumProperty(
        name="Axis",
        description="The local axis of each bone",
        items=(("X", "X", "Bend the bone"), ("Y", "Y", "Twist the bone"), ("Z", "Z", "Bend the bone sideways")),
    )
    angle: FloatProperty(
        name="Angle",
        description="Angle of a joint with an eagerness of 1. Other joints rotate by their eagerness times this angle",
        subtype="ANGLE",
        default=0.2,
        soft_min=-3.2,
        soft_max=3.2,
    )

    def run(self, context):
        selected = context.selected_pose_bones
        if not selected:
            raise SinewError("Select the bones to rotate")
        axis = "XYZ".index(self.axis)
        moved, driven = [], bone_limits.driven_bones(context.object)
        for bone in selected:
            if bone.name in driven:
                continue
            joint = bone_limits.joint_of(bone)
            if bone_limits.write(
                bone, joint.parameterisation, bone_limits.rotated_angles(joint, axis, self.angle * joint.eagerness)
            ):
                moved.append(bone.name)
        keying.key_if_automatic(context, context.object, moved)
        return f"{len(moved)} of {len(selected)} bones rotated"
