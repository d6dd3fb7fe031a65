# SPDX-License-Identifier: GPL-3.0-or-later
"""The settings of the active tissue."""

from bpy.types import Panel

from ..live import session
from ..scene import tissue_empty
from .sidebar import SidebarPanel, draw_settings, label_wrapped

NAME_FACTOR = 0.27  # of the width, for "Insertion"


class SINEW_PT_tissue(SidebarPanel, Panel):
    bl_idname = "SINEW_PT_tissue"
    bl_parent_id = "SINEW_PT_muscles"
    bl_label = "Selected Tissue"

    @classmethod
    def poll(cls, context):
        return context.object is not None and tissue_empty.is_tissue(context.object)

    def draw(self, context):
        layout = self.layout
        layout.use_property_split = True
        empty = context.object
        rig = empty.parent
        name = layout.row()
        name.use_property_split = False  # the whole width, because names are long
        name.prop(empty, "name", text="")
        layout.prop(empty.sinew.tissue, "kind")
        if rig is None or rig.type != "ARMATURE":
            label_wrapped(layout, "Parent it to a bone of an armature", "ERROR")
            return
        state = session.cached_rig(rig)
        if state and empty.name in state.problems:
            label_wrapped(layout, state.problems[empty.name], "ERROR")
        is_muscle = empty.sinew.tissue.kind == "MUSCLE"
        _draw_bone(layout, empty.sinew.tissue, "origin_bone", rig, "Origin")
        if is_muscle:
            _draw_bone(layout, empty.sinew.tissue, "insertion_bone", rig, "Insertion")
        _draw_sizes(layout, empty.sinew.tissue, is_muscle)
        if is_muscle:
            _draw_curve(layout)
        row = layout.row(align=True)
        row.operator("sinew.copy_tissue", text="Copy", icon="COPYDOWN")
        row.operator("sinew.paste_tissue", text="Paste", icon="PASTEDOWN")
        layout.operator("sinew.copy_settings", icon="COPYDOWN")


def _draw_bone(layout, settings, name: str, rig, text: str):
    split = layout.split(factor=NAME_FACTOR)  # names of bones are long
    split.use_property_split = False
    split.label(text=text)
    row = split.row()
    row.alert = getattr(settings, name) not in rig.data.bones
    row.prop_search(settings, name, rig.data, "bones", text="")


def _draw_sizes(layout, settings, is_muscle: bool):
    # these three edit the transform of the Empty; keys belong on the transform
    draw_settings(layout, settings, "semi_axes", "width_ratio", "offset")
    if is_muscle:
        draw_settings(layout, settings, "origin_tendon", "insertion_tendon", "volume_keeping", "tension", can_be_keyed=True)
        draw_settings(layout, settings, "influence")
    draw_settings(layout, settings, "skin_thickness")


def _draw_curve(layout):
    column = layout.column(align=True)
    column.operator("sinew.add_via_point", icon="CURVE_BEZCURVE")
    column.operator("sinew.remove_via_points", icon="X")
    layout.operator("sinew.wrap", icon="MOD_SHRINKWRAP")
