# SPDX-License-Identifier: GPL-3.0-or-later
"""The main panel: the active character and its problems."""

from bpy.types import Panel

from ..scene import characters
from ..settings import migration
from . import next_step, problems
from .sidebar import SidebarPanel, label_wrapped, rig_and_reason, rig_settings


class SINEW_PT_main(SidebarPanel, Panel):
    bl_idname = "SINEW_PT_main"
    bl_label = ""  # the header shows the view; a title would be cut off at the sidebar's default width

    def draw_header(self, context):
        rig, _reason = rig_and_reason(context)
        settings = rig_settings(rig) if rig else None
        if settings is None:
            self.layout.label(text="Sinew")
        else:
            self.layout.row(align=True).prop(settings, "view", expand=True)

    def draw(self, context):
        layout = self.layout
        rig, reason = rig_and_reason(context)
        for notice in migration.notices():
            label_wrapped(layout, notice, "INFO")
        if rig is None:
            next_step.draw(layout, context, None, reason)
            return
        character = characters.last_character_of(rig)
        layout.label(text=rig.name, icon="ARMATURE_DATA", translate=False)
        if character:
            counts = len(character.tissues), len(character.skins)
            label_wrapped(layout, f"Tissues: {counts[0]}, bound skins: {counts[1]}", "BLANK1")
        problems.draw(layout, problems.of(context, rig, character))
        next_step.draw(layout, context, rig, reason)
