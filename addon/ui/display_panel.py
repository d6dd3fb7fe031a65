# SPDX-License-Identifier: GPL-3.0-or-later
"""Muscle display: how the viewport shows skeleton, tissues and skins."""

from bpy.types import Panel

from ..display import shaded, visibility
from ..scene import characters
from . import text_width
from .sidebar import TissuesPanel, rig_and_reason, rig_settings
from .tissue_list import ICON_OF_KIND

NAME_PART = 0.35  # of the width, beside a menu and a switch


class SINEW_PT_display(TissuesPanel, Panel):
    bl_idname = "SINEW_PT_display"
    bl_parent_id = "SINEW_PT_main"
    bl_label = "Muscle Display"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context):
        layout = self.layout
        rig, _reason = rig_and_reason(context)
        _draw_object(layout, rig, "Skeleton", "ARMATURE_DATA").prop(rig, "show_in_front", text="", icon="XRAY")
        settings = rig_settings(rig)
        if settings is not None:
            column = layout.column(align=True)
            for kind, name in visibility.SHOW_OF_KIND.items():
                column.prop(settings, name, icon=ICON_OF_KIND[kind])
            column.prop(settings, "show_empties", icon="EMPTY_DATA")
            self._draw_shaded(layout, rig, settings)
            layout.row().prop(settings, "colours", expand=True)
            layout.prop(settings, "show_attachments")
        character = characters.last_character_of(rig)
        for key in character.skins if character else ():
            skin = key.find()
            if skin:
                shown = text_width.shortened(skin.name, NAME_PART * text_width.contents_width())
                _draw_object(layout, skin, shown, "MESH_DATA")

    def _draw_shaded(self, layout, rig, settings):
        row = layout.row(align=True)
        row.prop(settings, "show_shaded")
        display = shaded.find(rig)
        if display:
            row.prop(display, "show_wire", text="", icon="SHADING_WIRE")
            row.prop(display, "show_in_front", text="", icon="XRAY")
            row.prop(display, "hide_render", text="", emboss=False)


def _draw_object(layout, shown_object, text: str, icon: str):
    """Draws the display switches of an object; returns the row, to which more can be added."""
    row = layout.row(align=True)
    row.label(text=text, icon=icon, translate=shown_object.type == "ARMATURE")
    row.prop(shown_object, "hide_viewport", text="", emboss=False)
    row.prop(shown_object, "display_type", text="")
    return row
