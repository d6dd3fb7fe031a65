# SPDX-License-Identifier: GPL-3.0-or-later
"""The selected tissue: all that can be set on it."""

from bpy.types import Panel

from .. import session, tissue_io
from .sidebar import SidebarPanel, label_wrapped


class SINEW_PT_tissue(SidebarPanel, Panel):
    bl_idname = "SINEW_PT_tissue"
    bl_parent_id = "SINEW_PT_muscles"
    bl_label = "Selected Tissue"

    @classmethod
    def poll(cls, context):
        return context.object is not None and tissue_io.is_tissue(context.object)

    def draw(self, context):
        layout = self.layout
        layout.use_property_split = True
        empty = context.object
        rig = empty.parent
        layout.prop(empty, "name")
        layout.prop(empty.sinew, "kind")
        if rig is None or rig.type != "ARMATURE":
            layout.label(text="Parent it to a bone of an armature", icon="ERROR")
            return
        state = session.kept_rig(rig)
        if state and empty.name in state.problems:
            label_wrapped(layout, state.problems[empty.name], "ERROR")
        is_muscle = empty.sinew.kind == "MUSCLE"
        _draw_bone(layout, empty.sinew, "origin_bone", rig)
        if is_muscle:
            _draw_bone(layout, empty.sinew, "insertion_bone", rig)
        _draw_sizes(layout, empty.sinew, is_muscle)
        layout.prop(empty.sinew, "skin_thickness")
        if is_muscle:
            _draw_curve(layout)
        layout.operator("sinew.copy_settings", icon="COPYDOWN")


def _draw_bone(layout, settings, name: str, rig):
    row = layout.row()
    row.alert = getattr(settings, name) not in rig.data.bones
    row.prop_search(settings, name, rig.data, "bones")


def _draw_sizes(layout, settings, is_muscle: bool):
    column = layout.column()
    column.use_property_decorate = False  # these are other words for the Empty's transform, which can be keyed
    column.prop(settings, "semi_axes")
    column.prop(settings, "width_ratio")
    column.prop(settings, "offset")
    if not is_muscle:
        return
    column = layout.column()
    column.prop(settings, "origin_tendon")
    column.prop(settings, "insertion_tendon")
    column.prop(settings, "volume_keeping")
    column.prop(settings, "tension")


def _draw_curve(layout):
    row = layout.row(align=True)
    row.operator("sinew.add_via_point", icon="CURVE_BEZCURVE")
    row.operator("sinew.remove_via_points", icon="X")
    layout.operator("sinew.wrap", icon="MOD_SHRINKWRAP")
