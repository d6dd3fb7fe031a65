# SPDX-License-Identifier: GPL-3.0-or-later
"""The operators of Sinew, one verb per file."""

import bpy

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
from .copy_bone_settings import SINEW_OT_copy_bone_settings
from .copy_settings import SINEW_OT_copy_settings
from .edit_rest_pose import SINEW_OT_edit_rest_pose
from .export import SINEW_OT_export
from .fit import SINEW_OT_fit
from .grow_skin import SINEW_OT_grow_skin
from .load_musculature import SINEW_OT_load_musculature
from .measure import SINEW_OT_measure
from .mirror import SINEW_OT_mirror
from .paint_region import SINEW_OT_paint_region
from .reach import SINEW_OT_reach
from .remove import SINEW_OT_remove
from .remove_via_points import SINEW_OT_remove_via_points
from .rest_pose import SINEW_OT_rest_pose
from .rotate_joint import SINEW_OT_rotate_joint
from .save_musculature import SINEW_OT_save_musculature
from .unbind import SINEW_OT_unbind
from .wrap import SINEW_OT_wrap

CLASSES = (
    SinewSegmentBone,
    SINEW_OT_add_muscles,
    SINEW_OT_add_tissue,
    SINEW_OT_add_preset,
    SINEW_OT_add_automatic,
    SINEW_OT_add_via_point,
    SINEW_OT_remove_via_points,
    SINEW_OT_wrap,
    SINEW_OT_fit,
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
)


def register():
    for cls in CLASSES:
        bpy.utils.register_class(cls)


def unregister():
    for cls in reversed(CLASSES):
        if cls.is_registered:
            bpy.utils.unregister_class(cls)
