# SPDX-License-Identifier: GPL-3.0-or-later
"""The "Sinew" tab of the 3D viewport's sidebar: three steps, muscles, skin, bake."""

import bpy
from bpy.types import Panel

from .. import mesh_io, roster, session, tissue_io
from ..errors import SinewError


class _SinewPanel:
    bl_space_type = "VIEW_3D"
    bl_region_type = "UI"
    bl_category = "Sinew"


class SINEW_PT_main(_SinewPanel, Panel):
    bl_idname = "SINEW_PT_main"
    bl_label = "Sinew"

    def draw(self, context):
        layout = self.layout
        rig, reason = _rig_and_reason(context)
        if rig is None:
            layout.label(text=reason, icon="INFO")
            return
        character = roster.character_of(rig)
        state = session.kept_rig(rig)
        layout.label(text=rig.name, icon="ARMATURE_DATA")
        layout.label(text=f"Tissues: {len(character.tissues) if character else 0}")
        if state:
            for problem in state.problems.values():
                layout.label(text=problem, icon="ERROR")


class SINEW_PT_muscles(_SinewPanel, Panel):
    bl_idname = "SINEW_PT_muscles"
    bl_parent_id = "SINEW_PT_main"
    bl_label = "1 Muscles"

    def draw(self, context):
        layout = self.layout
        layout.operator_menu_enum("sinew.add_preset", "name", text="Add Muscles", icon="OUTLINER_OB_ARMATURE")
        layout.operator_menu_enum("sinew.add_tissue", "kind", text="Add Tissue", icon="ADD")
        layout.operator("sinew.fit", icon="SHADERFX")
        rig, _reason = _rig_and_reason(context)
        if rig:
            layout.prop(rig.sinew, "show_posed")


class SINEW_PT_tissue(_SinewPanel, Panel):
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
        settings = empty.sinew
        layout.prop(settings, "kind")
        rig = empty.parent
        if rig is None or rig.type != "ARMATURE":
            layout.label(text="Parent it to a bone of an armature", icon="ERROR")
            return
        layout.prop_search(settings, "origin_bone", rig.data, "bones")
        if settings.kind != "MUSCLE":
            return
        layout.prop_search(settings, "insertion_bone", rig.data, "bones")
        layout.prop(settings, "origin_tendon")
        layout.prop(settings, "insertion_tendon")
        layout.prop(settings, "volume_keeping")
        layout.prop(settings, "tension")


class SINEW_PT_skin(_SinewPanel, Panel):
    bl_idname = "SINEW_PT_skin"
    bl_parent_id = "SINEW_PT_main"
    bl_label = "2 Skin"

    def draw(self, context):
        layout = self.layout
        row = layout.row(align=True)
        row.operator("sinew.bind", icon="LINKED")
        row.operator("sinew.unbind", icon="UNLINKED")
        skin = _active_skin(context)
        if skin is None:
            return
        reason = session.reason(skin)
        if reason:
            layout.label(text=reason, icon="ERROR")
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


class SINEW_PT_bake(_SinewPanel, Panel):
    bl_idname = "SINEW_PT_bake"
    bl_parent_id = "SINEW_PT_main"
    bl_label = "3 Bake"

    def draw(self, context):
        layout = self.layout
        layout.operator("sinew.bake_shape_keys", icon="SHAPEKEY_DATA")
        skin = _active_skin(context)
        if skin and skin.sinew.bake_error_mm >= 0.0:
            layout.label(text=f"Last bake: {skin.sinew.bake_error_mm:.4f} mm from live at most")
        layout.operator("sinew.remove", icon="TRASH")


def _rig_and_reason(context):
    active = context.object
    if active is None:
        return None, "Select an armature or its mesh"
    if active.type == "ARMATURE":
        return active, ""
    if active.type == "MESH":
        try:
            return mesh_io.rig_of(active), ""
        except SinewError as error:
            return None, str(error)
    if active.parent and active.parent.type == "ARMATURE":
        return active.parent, ""
    return None, "Select an armature or its mesh"


def _active_skin(context):
    active = context.object
    if active and active.type == "MESH":
        return active if mesh_io.is_bound(active) else None
    rig, _reason = _rig_and_reason(context)
    character = roster.character_of(rig) if rig else None
    return character.skins[0].find() if character and character.skins else None


CLASSES = (SINEW_PT_main, SINEW_PT_muscles, SINEW_PT_tissue, SINEW_PT_skin, SINEW_PT_bake)


def register():
    for cls in CLASSES:
        bpy.utils.register_class(cls)


def unregister():
    for cls in reversed(CLASSES):
        bpy.utils.unregister_class(cls)
