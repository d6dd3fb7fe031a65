# SPDX-License-Identifier: GPL-3.0-or-later
"""Quality: measuring a skin, and the results of the last measurement."""

from bpy.types import Panel

from ..display import edge_stretch_colours
from ..scene import stored_settings
from .sidebar import BoundPanel, label_wrapped


class SINEW_PT_quality(BoundPanel, Panel):
    bl_idname = "SINEW_PT_quality"
    bl_parent_id = "SINEW_PT_main"
    bl_label = "Quality"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context):
        layout = self.layout
        layout.operator("sinew.measure", icon="DRIVER_DISTANCE")
        skin = context.object
        settings = stored_settings.skin_of(skin) if skin.type == "MESH" else None
        if settings is None or not settings.quality_summary:
            return
        for number, line in enumerate(settings.quality_summary.splitlines()):
            label_wrapped(layout, line, "BLANK1" if number else "INFO")
        if settings.quality_text:
            label_wrapped(layout, f"Text: {settings.quality_text.name}", "TEXT")
        if edge_stretch_colours.ATTRIBUTE in skin.data.color_attributes:
            where = "Viewport Shading > Color > Attribute"
            label_wrapped(layout, f"Heat map ({where}): {edge_stretch_colours.SCALE}", "COLOR")
