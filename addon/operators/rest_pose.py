# SPDX-License-Identifier: GPL-3.0-or-later
"""`sinew.rest_pose` rotates bones to the rest pose."""

from bpy.props import BoolProperty
from bpy.types import Operator

from ..errors import SinewError
from ..reach import drag, keying
from ..scene.linked_data import writable
from .base import SinewOperator, rig_of_context


class SINEW_OT_rest_pose(SinewOperator, Operator):
    """Rotate bones to the rest pose, as far as their limits and locks allow"""

    bl_idname, bl_label = "sinew.rest_pose", "Rest Pose"

    only_selected: BoolProperty(
        name="Only Selected",
        description="Rotate only the bones that are selected in Pose Mode. Off: all bones",
        default=False,
    )

    def run(self, context):
        rig = writable(rig_of_context(context))
        chosen = {bone.name for bone in context.selected_pose_bones or ()} if self.only_selected else None
        names = [bone.name for bone in rig.pose.bones if chosen is None or bone.name in chosen]
        if not names:
            raise SinewError("No bones are selected. Select bones in Pose Mode, or switch Only Selected off")
        context.view_layer.update()
        moved = drag.reset(rig, names)
        keying.key_if_automatic(context, rig, moved)
        return f"{len(moved)} bones of {rig.name} rotated to the rest pose"
