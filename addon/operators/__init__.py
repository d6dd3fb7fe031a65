# SPDX-License-Identifier: GPL-3.0-or-later
"""The operators, one verb a file."""

import bpy

from .add_automatic import SINEW_OT_add_automatic
from .add_preset import SINEW_OT_add_preset, SinewSegmentBone
from .add_tissue import SINEW_OT_add_tissue
from .bake_shape_keys import SINEW_OT_bake_shape_keys
from .bind import SINEW_OT_bind
from .fit import SINEW_OT_fit
from .remove import SINEW_OT_remove
from .unbind import SINEW_OT_unbind

CLASSES = (
    SinewSegmentBone,
    SINEW_OT_add_tissue,
    SINEW_OT_add_preset,
    SINEW_OT_add_automatic,
    SINEW_OT_fit,
    SINEW_OT_bind,
    SINEW_OT_unbind,
    SINEW_OT_bake_shape_keys,
    SINEW_OT_remove,
)


def register():
    for cls in CLASSES:
        bpy.utils.register_class(cls)


def unregister():
    for cls in reversed(CLASSES):
        bpy.utils.unregister_class(cls)
