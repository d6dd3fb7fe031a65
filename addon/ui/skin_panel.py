# SPDX-License-Identifier: GPL-3.0-or-later
"""Step 2, skin: binding a mesh to the muscles, and how it follows them."""

from bpy.types import Panel

from .. import session
from .sidebar import SidebarPanel, active_skin, label_wrapped


class SINEW_PT_skin(SidebarPanel, Panel):
    bl_idname = "SINEW_PT_skin"
    bl_parent_id = "SINEW_PT_main"
    bl_label = "2 Skin"

    def draw(self, context):
        layout = self.layout
        row = layout.row(align=True)
        row.operator("sinew.bind", icon="LINKED")
        row.operator("sinew.unbind", icon="UNLINKED")
        skin = active_skin(context)
        if skin is None:
            return
        reason = session.reason(skin)
        if reason:
            label_wrapped(layout, reason, "ERROR")
        column = layout.column()
        column.use_property_split = True
        column.use_property_decorate = False
        settings = skin.sinew
        column.prop(settings, "live")
        column.prop(settings, "anchoring")
        column.prop(settings, "carry")
        column.prop(settings, "gain")
        column.prop(settings, "reach")
        column.prop(settings, "scale_fat")
        column.prop(settings, "elastic")
        if settings.elastic:
            column.prop(settings, "iterations")
        if not context.scene.render.use_lock_interface:
            # a render thread and the viewport would otherwise write and read the same mesh at the same time
            layout.prop(context.scene.render, "use_lock_interface", text="Lock Interface while Rendering")
