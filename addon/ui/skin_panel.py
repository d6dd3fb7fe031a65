# SPDX-License-Identifier: GPL-3.0-or-later
"""Step 2, skin: binding a mesh to the muscles, how it follows them, and where it does so differently."""

from bpy.types import Panel

from .. import regional, session
from ..operators.base import active_bone
from .sidebar import SidebarPanel, active_skin, label_wrapped

MOST_NAMES = 6


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
        column = _settings_column(layout)
        settings = skin.sinew
        column.prop(settings, "live")
        column.prop(settings, "anchoring")
        column.prop(settings, "carry")
        column.prop(settings, "gain")
        column.prop(settings, "reach")
        column.prop(settings, "scale_fat")
        layout.operator_menu_enum("sinew.paint_region", "parameter", text="Paint Region", icon="WPAINT_HLT")
        if not context.scene.render.use_lock_interface:
            # a render thread and the viewport would otherwise write and read the same mesh at the same time
            layout.prop(context.scene.render, "use_lock_interface", text="Lock Interface while Rendering")
        _draw_report(layout, session.kept_skin(skin))


class SkinPanel(SidebarPanel):
    """Mix-in: a panel that needs a bound mesh."""

    @classmethod
    def poll(cls, context):
        return active_skin(context) is not None


class SINEW_PT_elasticity(SkinPanel, Panel):
    bl_idname = "SINEW_PT_elasticity"
    bl_parent_id = "SINEW_PT_skin"
    bl_label = "Elasticity"

    def draw_header(self, context):
        self.layout.prop(active_skin(context).sinew, "elastic", text="")

    def draw(self, context):
        settings = active_skin(context).sinew
        column = _settings_column(self.layout)
        column.active = settings.elastic
        column.prop(settings, "iterations")
        column.prop(settings, "energy")
        column.prop(settings, "anchor_stiffness")
        column.prop(settings, "edge_stiffness")
        column.prop(settings, "rest_distance")
        column.prop(settings, "fat_sliding")
        column.prop(settings, "collides")
        column.prop(settings, "contacts")


class SINEW_PT_segment(SkinPanel, Panel):
    bl_idname = "SINEW_PT_segment"
    bl_parent_id = "SINEW_PT_skin"
    bl_label = "Segment"
    bl_options = {"DEFAULT_CLOSED"}

    @classmethod
    def poll(cls, context):
        return super().poll(context) and active_bone(context) is not None

    def draw(self, context):
        layout = self.layout
        bone = active_bone(context)
        layout.label(text=bone.name, icon="BONE_DATA")
        column = _settings_column(layout)
        for parameter in regional.PARAMETERS:
            column.prop(bone.sinew, parameter.name)
        column.separator()
        for name in regional.JOINT_STRENGTHS:
            column.prop(bone.sinew, name)
        layout.operator_menu_enum("sinew.copy_bone_settings", "to", text="Copy Settings to", icon="COPYDOWN")


def _settings_column(layout):
    column = layout.column()
    column.use_property_split = True
    column.use_property_decorate = False  # none of these is animated
    return column


def _draw_report(layout, state: session.SkinState | None):
    """What the last frame met."""
    report = state.report if state else None
    if report is None:
        return
    clamped = report.clamped
    if clamped:
        more = f" and {len(clamped) - MOST_NAMES} more" if len(clamped) > MOST_NAMES else ""
        label_wrapped(layout, f"Can't shorten further: {', '.join(clamped[:MOST_NAMES])}{more}", "INFO")
    if report.damped:
        label_wrapped(layout, f"{report.damped} vertices held back, where bones flatten the skin", "INFO")
