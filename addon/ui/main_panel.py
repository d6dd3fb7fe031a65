# SPDX-License-Identifier: GPL-3.0-or-later
"""The main panel: the active character and its problems."""

from bpy.types import Panel

from ..live import session
from ..scene import characters
from ..settings import migration
from .sidebar import SidebarPanel, label_wrapped, rig_and_reason, rig_settings

MOST_PROBLEMS = 5


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
        if rig is None:
            label_wrapped(layout, reason, "INFO")
            return
        for notice in migration.notices():
            label_wrapped(layout, notice, "INFO")
        character = characters.character_of(rig)
        tissues, skins = (len(character.tissues), len(character.skins)) if character else (0, 0)
        layout.label(text=rig.name, icon="ARMATURE_DATA")
        layout.label(text=f"Tissues: {tissues}, bound skins: {skins}", icon="BLANK1")
        state = session.cached_rig(rig)
        problems = list(state.problems.values()) if state else []
        for problem in problems[:MOST_PROBLEMS]:
            label_wrapped(layout, problem, "ERROR")
        if len(problems) > MOST_PROBLEMS:
            layout.label(text=f"{len(problems) - MOST_PROBLEMS} more are marked in the list", icon="ERROR")
