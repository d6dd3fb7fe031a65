# SPDX-License-Identifier: GPL-3.0-or-later
"""Layers: skeleton, tissues by kind, skin; each shown or hidden, as wires or shaded."""

from bpy.types import Panel

from ..display import shaded, visibility
from ..scene import characters
from .sidebar import RigPanel, rig_and_reason
from .tissue_list import ICON_OF_KIND


class SINEW_PT_layers(RigPanel, Panel):
    bl_idname = "SINEW_PT_layers"
    bl_parent_id = "SINEW_PT_main"
    bl_label = "Layers"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context):
        layout = self.layout
        rig, _reason = rig_and_reason(context)
        _draw_object(layout, rig, "Skeleton", "ARMATURE_DATA").prop(rig, "show_in_front", text="", icon="XRAY")
        column = layout.column(align=True)
        for kind, name in visibility.SHOW_OF_KIND.items():
            column.prop(rig.sinew, name, icon=ICON_OF_KIND[kind])
        column.prop(rig.sinew, "show_empties", icon="EMPTY_DATA")
        self._draw_shaded(layout, rig)
        layout.prop(rig.sinew, "show_attachments")
        character = characters.character_of(rig)
        for key in character.skins if character else ():
            skin = key.find()
            if skin:
                _draw_object(layout, skin, skin.name, "MESH_DATA")

    def _draw_shaded(self, layout, rig):
        row = layout.row(align=True)
        row.prop(rig.sinew, "show_shaded")
        found = shaded.find(rig)
        if found:
            row.prop(found, "show_wire", text="", icon="SHADING_WIRE")
            row.prop(found, "show_in_front", text="", icon="XRAY")
            row.prop(found, "hide_render", text="", emboss=False)


def _draw_object(layout, shown, text: str, icon: str):
    """An object's own switches; returns its row for more of them."""
    row = layout.row(align=True)
    row.label(text=text, icon=icon)
    row.prop(shown, "hide_viewport", text="", emboss=False)
    row.prop(shown, "display_type", text="")
    return row
