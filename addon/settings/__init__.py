# SPDX-License-Identifier: GPL-3.0-or-later
"""The settings that a user makes, stored in Blender's data: one file per owner.

`object.sinew.tissue` (Empties of tissues and via points), `.skin` (meshes), `.rig` (armatures) and `.goal` (Empties of
goals); `pose_bone.sinew` for single bones. The names are a stable interface: scripts, keyframes and drivers use them.
"""

import bpy

from . import bone_settings, object_settings, preferences


def register():
    object_settings.register()
    bone_settings.register()
    for cls in preferences.CLASSES:
        bpy.utils.register_class(cls)


def unregister():
    for cls in reversed(preferences.CLASSES):
        if cls.is_registered:
            bpy.utils.unregister_class(cls)
    bone_settings.unregister()
    object_settings.unregister()
