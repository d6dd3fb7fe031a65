# SPDX-License-Identifier: GPL-3.0-or-later
"""Step 1, muscles: adding, listing, mirroring, saving and loading tissues."""

import bpy
from bpy.types import Panel

from ..scene import rig_pose
from .sidebar import RigPanel, TissuesPanel, label_wrapped, rig_and_reason, rig_settings


class SINEW_PT_muscles(TissuesPanel, Panel):
    bl_idname = "SINEW_PT_muscles"
    bl_parent_id = "SINEW_PT_main"
    bl_label = "1 Muscles"

    def draw(self, context):
        layout = self.layout
        rig, _reason = rig_and_reason(context)
        settings = rig_settings(rig)
        column = layout.column(align=True)
        column.operator_menu_enum("sinew.add_preset", "name", text="Add Preset", icon="OUTLINER_OB_ARMATURE")
        column.operator("sinew.add_automatic", icon="AUTO")
        column.operator_menu_enum("sinew.add_tissue", "kind", text="Add Tissue", icon="ADD")
        column.operator("sinew.draw_muscle", icon="GREASEPENCIL")
        column.operator("sinew.fit", icon="SHADERFX")
        if settings is not None:
            layout.template_list("SINEW_UL_tissues", "", bpy.data, "objects", settings, "active_tissue", rows=6)
        is_resting = rig.data.pose_position == "REST"
        text = "Editing the Rest Pose" if is_resting else "Edit Rest Pose"
        layout.operator("sinew.edit_rest_pose", text=text, icon="ARMATURE_DATA", depress=is_resting)
        if settings is not None:
            layout.prop(settings, "show_posed")


class SINEW_PT_mirror(TissuesPanel, Panel):
    bl_idname = "SINEW_PT_mirror"
    bl_parent_id = "SINEW_PT_muscles"
    bl_label = "Mirror"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context):
        layout = self.layout
        rig, _reason = rig_and_reason(context)
        layout.operator("sinew.mirror", text="Mirror Selected", icon="MOD_MIRROR").direction = "SELECTED"
        row = layout.row(align=True)
        row.operator("sinew.mirror", text="Left to Right").direction = "LEFT_TO_RIGHT"
        row.operator("sinew.mirror", text="Right to Left").direction = "RIGHT_TO_LEFT"
        settings = rig_settings(rig)
        if settings is None:
            return
        layout.prop(settings, "mirror_x")
        if settings.mirror_x and not rig_pose.is_resting(rig):
            label_wrapped(layout, "In a pose, X Mirror acts on handles only", "INFO")


class SINEW_PT_file(RigPanel, Panel):
    bl_idname = "SINEW_PT_file"
    bl_parent_id = "SINEW_PT_main"
    bl_label = "Presets and Files"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, _context):
        row = self.layout.row(align=True)
        row.operator("sinew.save_musculature", text="Save", icon="EXPORT")
        row.operator("sinew.load_musculature", text="Load", icon="IMPORT")
        self.layout.operator("sinew.transfer_muscles", icon="ARMATURE_DATA")
        self.layout.operator("sinew.mesh_to_tissues", icon="MESH_DATA")
        self.layout.operator("sinew.muscle_volumes", icon="SPREADSHEET")
        column = self.layout.column(align=True)
        column.operator_menu_enum("sinew.load_preset", "preset", text="My Presets", icon="PRESET")
        row = column.row(align=True)
        row.operator("sinew.save_preset", icon="ADD")
        row.operator("sinew.rename_preset", text="", icon="GREASEPENCIL")
        row.operator("sinew.delete_preset", text="", icon="REMOVE")
        column.operator("sinew.make_assets", icon="ASSET_MANAGER")
        self.layout.operator("sinew.remove", icon="TRASH")
