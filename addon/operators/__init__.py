# SPDX-License-Identifier: GPL-3.0-or-later
"""The operators of Sinew, one verb per file."""

import bpy

from . import angle_table, preset_assets, preset_items
from .add_automatic import SINEW_OT_add_automatic
from .add_goal import SINEW_OT_add_goal
from .add_muscles import SINEW_OT_add_muscles
from .add_preset import SINEW_OT_add_preset
from .add_tissue import SINEW_OT_add_tissue
from .add_via_point import SINEW_OT_add_via_point
from .bake_bones import SINEW_OT_bake_bones
from .bake_cache import SINEW_OT_bake_cache
from .bake_correctives import SINEW_OT_bake_correctives
from .bake_reach import SINEW_OT_bake_reach
from .bake_shape_keys import SINEW_OT_bake_shape_keys
from .bind import SINEW_OT_bind
from .bone_table import SinewSegmentBone
from .choose_tissue import SINEW_OT_choose_tissue, register_keys, unregister_keys
from .copy_bone_settings import SINEW_OT_copy_bone_settings
from .copy_settings import SINEW_OT_copy_settings
from .drag_handle import SINEW_OT_drag_handle
from .draw_muscle import SINEW_OT_draw_muscle
from .edit_rest_pose import SINEW_OT_edit_rest_pose
from .example_character import SINEW_OT_example_character
from .export import SINEW_OT_export
from .fit import SINEW_OT_fit
from .group_tissues import SINEW_OT_group_tissues, SINEW_OT_key_group, SINEW_OT_select_group
from .grow_skin import SINEW_OT_grow_skin
from .load_musculature import SINEW_OT_load_musculature
from .measure import SINEW_OT_measure
from .mesh_to_tissues import SINEW_OT_mesh_to_tissues
from .mirror import SINEW_OT_mirror
from .muscle_volumes import SINEW_OT_muscle_volumes
from .paint_region import SINEW_OT_paint_region
from .paste_tissue import SINEW_OT_copy_tissue, SINEW_OT_paste_tissue
from .range_of_motion import SINEW_OT_range_of_motion
from .reach import SINEW_OT_reach
from .remove import SINEW_OT_remove
from .remove_via_points import SINEW_OT_remove_via_points
from .repair import SINEW_OT_repair
from .rest_pose import SINEW_OT_rest_pose
from .rotate_joint import SINEW_OT_rotate_joint
from .save_musculature import SINEW_OT_save_musculature
from .transfer_muscles import SINEW_OT_transfer_muscles
from .unbind import SINEW_OT_unbind
from .user_presets import (
    SINEW_OT_delete_preset,
    SINEW_OT_load_preset,
    SINEW_OT_rename_preset,
    SINEW_OT_save_preset,
)
from .whats_wrong import SINEW_OT_whats_wrong
from .wrap import SINEW_OT_wrap

CLASSES = (
    *angle_table.CLASSES,
    SinewSegmentBone,
    SINEW_OT_add_muscles,
    SINEW_OT_add_tissue,
    SINEW_OT_add_preset,
    SINEW_OT_add_automatic,
    SINEW_OT_add_via_point,
    SINEW_OT_remove_via_points,
    SINEW_OT_wrap,
    SINEW_OT_fit,
    SINEW_OT_muscle_volumes,
    SINEW_OT_mesh_to_tissues,
    SINEW_OT_transfer_muscles,
    SINEW_OT_edit_rest_pose,
    SINEW_OT_mirror,
    SINEW_OT_copy_settings,
    SINEW_OT_save_musculature,
    SINEW_OT_load_musculature,
    SINEW_OT_grow_skin,
    SINEW_OT_bind,
    SINEW_OT_unbind,
    SINEW_OT_paint_region,
    SINEW_OT_copy_bone_settings,
    SINEW_OT_bake_shape_keys,
    SINEW_OT_bake_cache,
    SINEW_OT_bake_correctives,
    SINEW_OT_bake_bones,
    SINEW_OT_export,
    SINEW_OT_measure,
    SINEW_OT_reach,
    SINEW_OT_rotate_joint,
    SINEW_OT_rest_pose,
    SINEW_OT_add_goal,
    SINEW_OT_bake_reach,
    SINEW_OT_remove,
    SINEW_OT_choose_tissue,
    SINEW_OT_repair,
    SINEW_OT_group_tissues,
    SINEW_OT_select_group,
    SINEW_OT_key_group,
    SINEW_OT_copy_tissue,
    SINEW_OT_paste_tissue,
    SINEW_OT_range_of_motion,
    SINEW_OT_example_character,
    SINEW_OT_whats_wrong,
    SINEW_OT_save_preset,
    SINEW_OT_load_preset,
    SINEW_OT_rename_preset,
    SINEW_OT_delete_preset,
    preset_assets.SINEW_OT_make_assets,
    preset_assets.SINEW_OT_drop_preset,
    SINEW_OT_drag_handle,
    SINEW_OT_draw_muscle,
)


def register():
    preset_items.register()
    for cls in CLASSES:
        bpy.utils.register_class(cls)
    register_keys()
    preset_assets.register()


def unregister():
    preset_assets.unregister()
    unregister_keys()
    for cls in reversed(CLASSES):
        if cls.is_registered:
            bpy.utils.unregister_class(cls)
    preset_items.unregister()
