# SPDX-License-Identifier: GPL-3.0-or-later
"""The user interface: the "Sinew" tab in the sidebar of the 3D viewport, and lines drawn over the viewport."""

import bpy
from bpy.props import BoolProperty

from ..display import timing_overlay
from . import (
    attachment_lines,
    bake_panel,
    display_panel,
    grow_panel,
    main_panel,
    menus,
    meshes_panel,
    mix_panel,
    moved_overlay,
    muscle_gizmos,
    muscles_panel,
    online_manual,
    quality_panel,
    reach_panel,
    skin_panel,
    tissue_list,
    tissue_panel,
)

# Blender shows panels in the order of their registration
_CLASSES = (
    tissue_list.SINEW_UL_tissues,
    main_panel.SINEW_PT_main,
    muscles_panel.SINEW_PT_muscles,
    tissue_panel.SINEW_PT_tissue,
    mix_panel.SINEW_PT_mix,
    muscles_panel.SINEW_PT_mirror,
    skin_panel.SINEW_MT_paint_region,
    skin_panel.SINEW_PT_skin,
    meshes_panel.SINEW_PT_meshes,
    skin_panel.SINEW_PT_elasticity,
    skin_panel.SINEW_PT_level_of_detail,
    skin_panel.SINEW_PT_bone_settings,
    grow_panel.SINEW_PT_grow,
    bake_panel.SINEW_PT_bake,
    quality_panel.SINEW_PT_quality,
    display_panel.SINEW_PT_display,
    muscles_panel.SINEW_PT_file,
    reach_panel.SINEW_PT_reach,
    reach_panel.SINEW_PT_goal,
    *menus.CLASSES,
)


def register():
    for cls in _CLASSES:
        bpy.utils.register_class(cls)
    attachment_lines.register()
    online_manual.register()
    menus.register()
    muscle_gizmos.register()
    bpy.types.WindowManager.sinew_show_moved = BoolProperty(
        name="Show What It Moves",
        description="Color the skin by how strongly the chosen tissue moves it, in viewports with overlays",
        options=set(),
        get=lambda _manager: moved_overlay.is_shown(),
        set=lambda _manager, shown: moved_overlay.show(shown),
    )


def unregister():
    muscle_gizmos.unregister()
    menus.unregister()
    moved_overlay.show(False)
    del bpy.types.WindowManager.sinew_show_moved
    timing_overlay.unregister()
    online_manual.unregister()
    attachment_lines.unregister()
    for cls in reversed(_CLASSES):
        if cls.is_registered:
            bpy.utils.unregister_class(cls)
