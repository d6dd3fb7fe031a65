# SPDX-License-Identifier: GPL-3.0-or-later
"""The main panel: whose character this is, and what is wrong with it."""

from bpy.types import Panel

from ..live import session
from ..scene import characters
from .sidebar import SidebarPanel, label_wrapped, rig_and_reason

MOST_PROBLEMS = 5


class SINEW_PT_main(SidebarPanel, Panel):
    bl_idname = "SINEW_PT_main"
    bl_label = "Sinew"

    def draw(self, context):
        layout = self.layout
        rig, reason = rig_and_reason(context)
        if rig is None:
            label_wrapped(layout, reason, "INFO")
            return
        character = characters.character_of(rig)
        tissues, skins = (len(character.tissues), len(character.skins)) if character else (0, 0)
        layout.label(text=f"{rig.name}: tissues: {tissues}, skins bound: {skins}", icon="ARMATURE_DATA")
        state = session.kept_rig(rig)
        problems = list(state.problems.values()) if state else []
        for problem in problems[:MOST_PROBLEMS]:
            label_wrapped(layout, problem, "ERROR")
        if len(problems) > MOST_PROBLEMS:
            layout.label(text=f"and {len(problems) - MOST_PROBLEMS} more, marked in the list", icon="ERROR")
