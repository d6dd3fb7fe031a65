# SPDX-License-Identifier: GPL-3.0-or-later
"""The meshes of the active character, each with its state: bound, not bound, left or refused, with the reason."""

from bpy.types import Panel

from ..scene import armature_modifier
from ..skin import bind_outcomes
from .sidebar import RigPanel, draw_settings, label_wrapped, rig_and_reason

ICON_OF_STATE = {"BOUND": "CHECKMARK", "PROBLEM": "ERROR", "LEFT": "INFO", "UNBOUND": "RADIOBUT_OFF"}
WORD_OF_STATE = {"BOUND": "bound", "PROBLEM": "bound, not moving", "LEFT": "left", "UNBOUND": "not bound"}


class SINEW_PT_meshes(RigPanel, Panel):
    bl_idname = "SINEW_PT_meshes"
    bl_parent_id = "SINEW_PT_skin"
    bl_label = "Meshes"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context):
        rig, _reason = rig_and_reason(context)
        states = bind_outcomes.states_of(rig)
        if not states:
            label_wrapped(self.layout, "No mesh follows this armature", "INFO")
        for mesh in states:
            column = self.layout.column(align=True)
            label_wrapped(column, f"{mesh.name}: {WORD_OF_STATE[mesh.state]}", ICON_OF_STATE[mesh.state])
            if mesh.reason:
                label_wrapped(column, mesh.reason, "BLANK1")
        skin = context.object
        if skin.type == "MESH" and armature_modifier.is_bound(skin):
            draw_settings(self.layout, skin.sinew.skin, "worn_over")
