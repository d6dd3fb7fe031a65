# SPDX-License-Identifier: GPL-3.0-or-later
"""Mix: groups of muscles with mute, solo, tension and influence, and what the chosen muscle moves."""

from bpy.types import Panel

from .sidebar import TissuesPanel, rig_and_reason


class SINEW_PT_mix(TissuesPanel, Panel):
    bl_idname = "SINEW_PT_mix"
    bl_parent_id = "SINEW_PT_muscles"
    bl_label = "Mix"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context):
        layout = self.layout
        layout.prop(context.window_manager, "sinew_show_moved", icon="COLOR")
        rig, _reason = rig_and_reason(context)
        layout.operator("sinew.group_tissues", text="Group by Region", icon="GROUP").by = "REGION"
        for group in rig.sinew.rig.groups:
            self.layout.separator(factor=0.3)
            column = layout.column(align=True)
            row = column.row(align=True)
            row.operator(
                "sinew.select_group", text=group.name, icon="RESTRICT_SELECT_OFF", translate=False
            ).group = group.name
            row.prop(group, "solo", text="", icon="SOLO_ON" if group.solo else "SOLO_OFF")
            row.prop(group, "muted", text="", icon="HIDE_ON" if group.muted else "HIDE_OFF")
            row = column.row(align=True)
            row.prop(group, "tension", slider=True)
            row.operator("sinew.key_group", text="", icon="KEY_HLT").group = group.name
            column.prop(group, "influence", slider=True)
