# SPDX-License-Identifier: GPL-3.0-or-later
"""Quality: measuring the skin, and what the last measurement found."""

from bpy.types import Panel

from ..display import strain_colours
from .sidebar import RigPanel, label_wrapped

CHARACTERS = 34  # a line: figures are wider than letters


class SINEW_PT_quality(RigPanel, Panel):
    bl_idname = "SINEW_PT_quality"
    bl_parent_id = "SINEW_PT_main"
    bl_label = "Quality"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context):
        layout = self.layout
        layout.operator("sinew.measure", icon="DRIVER_DISTANCE")
        skin = context.object
        if skin.type != "MESH" or not skin.is_property_set("sinew") or not skin.sinew.quality_summary:
            return
        for number, line in enumerate(skin.sinew.quality_summary.splitlines()):
            label_wrapped(layout, line, "BLANK1" if number else "INFO", CHARACTERS)
        if skin.sinew.quality_text:
            layout.label(text=f"Text: {skin.sinew.quality_text.name}", icon="TEXT")
        if strain_colours.ATTRIBUTE in skin.data.color_attributes:
            where = "Viewport Shading > Color > Attribute"
            label_wrapped(layout, f"Heat map ({where}): {strain_colours.SCALE}", "COLOR", CHARACTERS)
