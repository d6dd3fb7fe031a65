# SPDX-License-Identifier: GPL-3.0-or-later
"""`sinew.edit_rest_pose` switches an armature between its rest pose and its pose."""

from bpy.types import Operator

from ..errors import SinewError
from .base import SinewOperator, rig_of_context


class SINEW_OT_edit_rest_pose(SinewOperator, Operator):
    """Show the rest pose of the armature, where transforms of Empties edit their tissues. Use again to show the pose"""

    bl_idname, bl_label = "sinew.edit_rest_pose", "Edit Rest Pose"

    def run(self, context):
        rig = rig_of_context(context)
        if rig.data.library:
            raise SinewError(f"{rig.data.name} is linked from another file. Make a library override of it first")
        # Blender's own switch keeps the pose, and its state is visible in Blender's panels too
        is_editing = rig.data.pose_position == "REST"
        rig.data.pose_position = "POSE" if is_editing else "REST"
        return f"{rig.name} shows its pose again" if is_editing else f"{rig.name} shows its rest pose. Tissues can be edited"
