# SPDX-License-Identifier: GPL-3.0-or-later
"""The settings that a user makes, stored in Blender's data: one file per owner.

`object.sinew.tissue` (Empties of tissues and via points), `.skin` (meshes), `.rig` (armatures) and `.goal` (Empties of
goals); `pose_bone.sinew` for single bones. The names are a stable interface: scripts, keyframes and drivers use them.
"""

from . import bone_settings, object_settings


def register():
    object_settings.register()
    bone_settings.register()


def unregister():
    bone_settings.unregister()
    object_settings.unregister()
