# SPDX-License-Identifier: GPL-3.0-or-later
"""Motion: reach, joints, goals, and the times of frames."""

from bpy.types import Panel

from ..scene import stored_settings
from .sidebar import RigPanel, draw_settings, rig_and_reason


class SINEW_PT_reach(RigPanel, Panel):
    bl_idname = "SINEW_PT_reach"
    bl_parent_id = "SINEW_PT_main"
    bl_label = "Motion"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context):
        layout = self.layout
        layout.operator("sinew.reach", icon="CON_KINEMATIC")
        row = layout.row(align=True)
        row.operator("sinew.rotate_joint", icon="DRIVER_ROTATIONAL_DIFFERENCE")
        row.operator("sinew.rest_pose", icon="ARMATURE_DATA")
        bone = context.active_pose_bone
        if bone:
            layout.prop(bone.sinew, "eagerness", slider=True)
        layout.operator("sinew.add_goal", icon="EMPTY_ARROWS")
        rig, _reason = rig_and_reason(context)
        if rig:
            layout.operator("sinew.bake_reach", icon="KEYINGSET")
        layout.prop(context.window_manager, "sinew_show_times")


class SINEW_PT_goal(Panel):
    bl_idname = "SINEW_PT_goal"
    bl_label = "Sinew Goal"
    bl_space_type, bl_region_type, bl_category = "VIEW_3D", "UI", "Sinew"

    @classmethod
    def poll(cls, context):
        active = context.object
        return active is not None and active.type == "EMPTY" and stored_settings.rig_of_goal(active) is not None

    def draw(self, context):
        goal = context.object.sinew.goal
        column = self.layout.column()
        column.use_property_split = True
        column.use_property_decorate = False
        column.prop(goal, "rig")
        column.prop_search(goal, "bone", goal.rig.pose, "bones")
        draw_settings(column, goal, "at_tail", "chain_length", "position_weight", "orientation_weight", "look_at_weight")
        if goal.look_at_weight > 0.0:
            column.prop(goal, "look_axis")
