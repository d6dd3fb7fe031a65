# SPDX-License-Identifier: GPL-3.0-or-later
"""`sinew.edit_rest_pose`"""

from bpy.types import Operator

from ..errors import SinewError
from .base import SinewOperator, rig_of_context


class SINEW_OT_edit_rest_pose(SinewOperator, Operator):
    """Show the armature in its rest pose, where moving, turning and scaling an Empty edits its tissue; again: the pose is back"""

    bl_idname, bl_label = "sinew.edit_rest_pose", "Edit Rest Pose"

    def run(self, context):
        rig = rig_of_context(context)
        if rig.data.library:
            raise SinewError(f"{rig.data.name} is linked from another file: make a library override of it first")
        # Blender's own switch: it leaves the pose itself alone, and everybody sees which of the two is shown
        is_editing = rig.data.pose_position == "REST"
        rig.data.pose_position = "POSE" if is_editing else "REST"
        return f"{rig.name} shows its pose again" if is_editing else f"{rig.name} shows its rest pose: tissues can be edited"
