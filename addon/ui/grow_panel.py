# SPDX-License-Identifier: GPL-3.0-or-later
"""Growing a skin over the tissues of an armature."""

from bpy.types import Panel

from ..scene import characters
from ..settings import growth_settings
from ..skin import grow
from .sidebar import TissuesPanel, draw_settings, rig_and_reason


class SINEW_PT_grow(TissuesPanel, Panel):
    bl_idname = "SINEW_PT_grow"
    bl_parent_id = "SINEW_PT_skin"
    bl_label = "Grow from Muscles"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context):
        layout = self.layout
        rig, _reason = rig_and_reason(context)
        character = characters.last_character_of(rig)
        skins = [key.find() for key in character.skins] if character else []
        skin = next((mesh for mesh in skins if mesh and grow.is_grown(mesh)), None)
        layout.operator("sinew.grow_skin", text="Grow Skin Again" if skin else "Grow Skin", icon="OUTLINER_OB_META")
        if skin is None:
            return
        draw_settings(layout, skin.sinew.skin.growth, *growth_settings.OPTIONS)
