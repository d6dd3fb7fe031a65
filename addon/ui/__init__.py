# SPDX-License-Identifier: GPL-3.0-or-later
"""What a person sees: the "Sinew" tab in the sidebar of the 3D viewport, and lines drawn over the viewport."""

import bpy

from ..display import timing_overlay
from . import (
    attachment_lines,
    bake_panel,
    grow_panel,
    layers_panel,
    main_panel,
    muscles_panel,
    quality_panel,
    reach_panel,
    skin_panel,
    tissue_list,
    tissue_panel,
)

# panels stand in the sidebar in the order in which they are registered
_CLASSES = (
    tissue_list.SINEW_UL_tissues,
    main_panel.SINEW_PT_main,
    muscles_panel.SINEW_PT_muscles,
    tissue_panel.SINEW_PT_tissue,
    muscles_panel.SINEW_PT_automatic,
    muscles_panel.SINEW_PT_mirror,
    muscles_panel.SINEW_PT_file,
    skin_panel.SINEW_PT_skin,
    skin_panel.SINEW_PT_elasticity,
    skin_panel.SINEW_PT_segment,
    grow_panel.SINEW_PT_grow,
    bake_panel.SINEW_PT_bake,
    quality_panel.SINEW_PT_quality,
    layers_panel.SINEW_PT_layers,
    reach_panel.SINEW_PT_reach,
    reach_panel.SINEW_PT_goal,
)


def register():
    for cls in _CLASSES:
        bpy.utils.register_class(cls)
    attachment_lines.register()


def unregister():
    timing_overlay.unregister()
    attachment_lines.unregister()
    for cls in reversed(_CLASSES):
        bpy.utils.unregister_class(cls)
