# SPDX-License-Identifier: GPL-3.0-or-later
"""Step 3, bake: shape keys, correctives, point cache, muscle bones, export, and removal of Sinew."""

from bpy.types import Panel

from .sidebar import BoundPanel, active_skin, label_wrapped

SHOWN_LINES = 6


class SINEW_PT_bake(BoundPanel, Panel):
    bl_idname = "SINEW_PT_bake"
    bl_parent_id = "SINEW_PT_main"
    bl_label = "3 Bake"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context):
        layout = self.layout
        layout.operator("sinew.bake_shape_keys", icon="SHAPEKEY_DATA")
        skin = active_skin(context)
        if skin and skin.sinew.skin.bake_error_mm >= 0.0:
            label_wrapped(layout, f"Maximum error: {skin.sinew.skin.bake_error_mm:.4f} mm", "INFO")
        layout.operator("sinew.bake_correctives", icon="DRIVER")
        if skin and skin.sinew.skin.corrective_summary:
            for number, line in enumerate(skin.sinew.skin.corrective_summary.splitlines()[:SHOWN_LINES]):
                label_wrapped(layout, line, "BLANK1" if number else "INFO")
        layout.operator("sinew.bake_cache", icon="FILE_CACHE")
        layout.operator("sinew.bake_bones", icon="GROUP_BONE")
        layout.operator("sinew.export", icon="EXPORT")
