# SPDX-License-Identifier: GPL-3.0-or-later
"""Step 2, skin: binding, skin settings, elasticity, and the settings of the active bone."""

from bpy.types import Menu, Panel

from ..live import session
from ..live.skin_cache import SkinState
from ..operators.base import active_bone
from ..operators.paint_region import PARAMETERS
from ..scene import skin_regions
from .sidebar import CharacterPanel, SidebarPanel, active_skin, draw_settings, label_wrapped

MOST_NAMES = 6


class SINEW_PT_skin(CharacterPanel, Panel):
    bl_idname = "SINEW_PT_skin"
    bl_parent_id = "SINEW_PT_main"
    bl_label = "2 Skin"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context):
        layout = self.layout
        row = layout.row(align=True)
        row.operator("sinew.bind", icon="LINKED")
        row.operator("sinew.unbind", icon="UNLINKED")
        skin = active_skin(context)
        if skin is None:
            return
        settings = skin.sinew.skin
        draw_settings(layout, settings, "live", "anchoring", "motion_source", "muscle_influence", "falloff", "scale_fat")
        layout.menu("SINEW_MT_paint_region", icon="WPAINT_HLT")
        if not context.scene.render.use_lock_interface:
            # without it, the render thread and the viewport can use the same mesh at the same time
            layout.prop(context.scene.render, "use_lock_interface", text="Lock Interface while Rendering")
        _draw_report(layout, session.cached_skin(skin))


class SINEW_MT_paint_region(Menu):
    """Choose the setting to paint"""

    bl_label = "Paint Region"

    def draw(self, _context):
        for name, label, _description in PARAMETERS:
            self.layout.operator("sinew.paint_region", text=label).parameter = name


class SkinPanel(SidebarPanel):
    """Mix-in: a panel that needs a bound mesh."""

    @classmethod
    def poll(cls, context):
        return active_skin(context) is not None


class SINEW_PT_elasticity(SkinPanel, Panel):
    bl_idname = "SINEW_PT_elasticity"
    bl_parent_id = "SINEW_PT_skin"
    bl_label = "Elasticity"
    bl_options = {"DEFAULT_CLOSED"}

    def draw_header(self, context):
        self.layout.prop(active_skin(context).sinew.skin, "elastic", text="")

    def draw(self, context):
        settings = active_skin(context).sinew.skin
        column = self.layout.column()
        column.active = settings.elastic
        draw_settings(
            column, settings, "iterations", "render_iterations", "energy", "anchor_stiffness", "edge_stiffness", "slack",
            "fat_sliding", "contacts", "safeguard",
        )  # fmt: skip


class SINEW_PT_level_of_detail(SkinPanel, Panel):
    bl_idname = "SINEW_PT_level_of_detail"
    bl_parent_id = "SINEW_PT_skin"
    bl_label = "Level of Detail"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context):
        settings = active_skin(context).sinew.skin
        names = ("viewport_detail", "render_detail", "elastic_distance", "muscle_distance")
        draw_settings(self.layout, settings, *names)


class SINEW_PT_bone_settings(SkinPanel, Panel):
    bl_idname = "SINEW_PT_bone_settings"
    bl_parent_id = "SINEW_PT_skin"
    bl_label = "Bone Settings"
    bl_options = {"DEFAULT_CLOSED"}

    @classmethod
    def poll(cls, context):
        return super().poll(context) and active_bone(context) is not None

    def draw(self, context):
        layout = self.layout
        bone = active_bone(context)
        layout.label(text=bone.name, icon="BONE_DATA", translate=False)
        draw_settings(layout, bone.sinew, *(parameter.name for parameter in skin_regions.PARAMETERS))
        draw_settings(layout, bone.sinew, *skin_regions.JOINT_STRENGTHS)
        draw_settings(layout, bone.sinew, *skin_regions.OF_GROWTH)
        layout.operator_menu_enum("sinew.copy_bone_settings", "to", text="Copy Settings to", icon="COPYDOWN")


def _draw_report(layout, state: SkinState | None):
    """Draws the warnings of the last frame."""
    report = state.report if state else None
    if report is None:
        return
    clamped = report.clamped
    if clamped:
        more = f" and {len(clamped) - MOST_NAMES} more" if len(clamped) > MOST_NAMES else ""
        label_wrapped(layout, f"At minimum length: {', '.join(clamped[:MOST_NAMES])}{more}", "INFO")
    if report.damped:
        label_wrapped(layout, f"Correction limited on {report.damped} vertices (scaled bones)", "INFO")
