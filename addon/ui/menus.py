# SPDX-License-Identifier: GPL-3.0-or-later
"""The menus Object > Sinew and Pose > Sinew, which make F3 find every operator, and the pie menu of the common ones."""

import bpy
from bpy.types import Menu

from .sidebar import rig_and_reason, rig_settings

KEY = ("M", {"shift": True, "alt": True})
KEYMAPS = (("Object Mode", "EMPTY"), ("Pose", "EMPTY"))
_registered: list = []


class SINEW_MT_muscles(Menu):
    """Add, change and copy muscles"""

    bl_label = "Muscles"

    def draw(self, _context):
        layout = self.layout
        layout.operator("sinew.add_muscles")
        layout.operator_menu_enum("sinew.add_preset", "name", text="Add Preset")
        layout.operator("sinew.add_automatic")
        layout.operator_menu_enum("sinew.add_tissue", "kind", text="Add Tissue")
        layout.operator("sinew.draw_muscle")
        for name in (
            *("add_via_point", "remove_via_points", "wrap", "fit", "mirror", "copy_settings", "edit_rest_pose"),
            *("muscle_volumes", "transfer_muscles", "mesh_to_tissues"),
            *("group_tissues", "select_group", "key_group", "copy_tissue", "paste_tissue"),
            *(
                "save_musculature",
                "load_musculature",
                "save_preset",
                "load_preset",
                "rename_preset",
                "delete_preset",
                "make_assets",
            ),
        ):
            layout.operator(f"sinew.{name}")


class SINEW_MT_skin(Menu):
    """Bind, paint and measure the skin"""

    bl_label = "Skin"

    def draw(self, _context):
        for name in ("bind", "unbind", "grow_skin", "paint_region", "copy_bone_settings", "measure"):
            self.layout.operator(f"sinew.{name}")


class SINEW_MT_bake(Menu):
    """Keep the result as data that works without Sinew"""

    bl_label = "Bake"

    def draw(self, _context):
        for name in ("bake_shape_keys", "bake_correctives", "bake_cache", "bake_bones", "bake_reach", "export"):
            self.layout.operator(f"sinew.{name}")


class SINEW_MT_motion(Menu):
    """Reach, joints and goals"""

    bl_label = "Motion"

    def draw(self, _context):
        for name in ("reach", "rotate_joint", "rest_pose", "add_goal", "range_of_motion"):
            self.layout.operator(f"sinew.{name}")


class SINEW_MT_sinew(Menu):
    """Muscles, skin and bakes of the active character"""

    bl_label = "Sinew"

    def draw(self, _context):
        layout = self.layout
        for menu in ("SINEW_MT_muscles", "SINEW_MT_skin", "SINEW_MT_bake", "SINEW_MT_motion"):
            layout.menu(menu)
        layout.separator()
        for name in ("example_character", "whats_wrong"):
            layout.operator(f"sinew.{name}")
        layout.separator()
        layout.operator("sinew.remove", icon="TRASH")


class SINEW_MT_pie(Menu):
    """The common operators, around the mouse"""

    bl_label = "Sinew"

    def draw(self, context):
        pie = self.layout.menu_pie()
        pie.operator("sinew.bind", icon="LINKED")
        pie.operator("sinew.edit_rest_pose", icon="ARMATURE_DATA")
        pie.operator_menu_enum("sinew.add_preset", "name", text="Add Preset", icon="OUTLINER_OB_ARMATURE")
        rig, _reason = rig_and_reason(context)
        settings = rig_settings(rig) if rig else None
        if settings is None:
            pie.separator()
        else:
            pie.row().prop(settings, "view", expand=True)
        pie.operator("sinew.fit", icon="SHADERFX")
        pie.operator("sinew.mirror", icon="MOD_MIRROR")
        pie.operator("sinew.bake_shape_keys", icon="SHAPEKEY_DATA")
        pie.operator("sinew.reach", icon="CON_KINEMATIC")


CLASSES = (
    SINEW_MT_muscles,
    SINEW_MT_skin,
    SINEW_MT_bake,
    SINEW_MT_motion,
    SINEW_MT_sinew,
    SINEW_MT_pie,
)


def _draw_in_menu(self, _context):
    self.layout.separator()
    self.layout.menu("SINEW_MT_sinew")


def register():
    """Adds the menus to Blender's, and the key of the pie menu. Without a window there is no keymap."""
    for menu in (bpy.types.VIEW3D_MT_object, bpy.types.VIEW3D_MT_pose):
        menu.append(_draw_in_menu)
    keys = bpy.context.window_manager.keyconfigs.addon
    for name, space in KEYMAPS if keys else ():
        keymap = keys.keymaps.new(name=name, space_type=space)
        item = keymap.keymap_items.new("wm.call_menu_pie", KEY[0], "PRESS", **KEY[1])
        item.properties.name = "SINEW_MT_pie"
        _registered.append((keymap, item))


def unregister():
    for menu in (bpy.types.VIEW3D_MT_object, bpy.types.VIEW3D_MT_pose):
        menu.remove(_draw_in_menu)
    for keymap, item in _registered:
        keymap.keymap_items.remove(item)
    _registered.clear()
