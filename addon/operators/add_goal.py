# SPDX-License-Identifier: GPL-3.0-or-later
"""`sinew.add_goal` adds goals for the selected bones."""

from bpy.types import Operator

from ..errors import SinewError
from ..reach import goals
from ..scene.linked_data import writable
from .base import PoseModeOperator


class SINEW_OT_add_goal(PoseModeOperator, Operator):
    """Add an Empty at the tail of each selected bone. Bake Reach makes the bone reach for it"""

    bl_idname, bl_label = "sinew.add_goal", "Add Goal"

    def run(self, context):
        selected = context.selected_pose_bones
        if not selected:
            raise SinewError("Select the bones that need a goal")
        rig = writable(context.object)
        context.view_layer.update()
        made = [goals.create(rig, bone.name) for bone in selected]
        return f"{len(made)} goals added. Animate them, then use Bake Reach"
