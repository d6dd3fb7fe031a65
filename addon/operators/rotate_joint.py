# SPDX-License-Identifier: GPL-3.0-or-later
"""`sinew.rotate_joint`"""

from bpy.props import EnumProperty, FloatProperty
from bpy.types import Operator

from ..errors import SinewError
from ..reach import bone_limits, keying
from .base import PoseModeOperator


class SINEW_OT_rotate_joint(PoseModeOperator, Operator):
    """Turn the selected bones about one of their own axes, each as far as its eagerness says and its limits allow"""

    bl_idname, bl_label = "sinew.rotate_joint", "Rotate Joint"

    axis: EnumProperty(
        name="Axis",
        description="The bones' own axis",
        items=(("X", "X", "Bend"), ("Y", "Y", "Twist"), ("Z", "Z", "Bend sideways")),
    )
    angle: FloatProperty(
        name="Angle", description="For an eagerness of 1", subtype="ANGLE", default=0.2, soft_min=-3.2, soft_max=3.2
    )

    def run(self, context):
        selected = context.selected_pose_bones
        if not selected:
            raise SinewError("Select the bones that shall turn")
        axis = "XYZ".index(self.axis)
        moved, driven = [], bone_limits.driven_bones(context.object)
        for bone in selected:
            if bone.name in driven:
                continue
            joint = bone_limits.joint_of(bone)
            if bone_limits.write(bone, joint.freedoms, bone_limits.turned(joint, axis, self.angle * joint.multiplier)):
                moved.append(bone.name)
        keying.key_if_automatic(context, context.object, moved)
        return f"{len(moved)} of {len(selected)} bones turned"
