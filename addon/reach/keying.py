# SPDX-License-Identifier: GPL-3.0-or-later
"""Rotation keys for the bones that a reach rotated."""

from . import bone_limits


def key(rig, bones: list[str], frame: float):
    """Inserts rotation keys for bones, each in its rotation mode, grouped by bone as Blender does."""
    for name in bones:
        bone = rig.pose.bones[name]
        bone.keyframe_insert(bone_limits.rotation_path(bone), frame=frame, group=name)


def key_if_automatic(context, rig, bones: list[str]) -> bool:
    """As `key` at the current frame, if Blender's Auto Keying is on. Returns whether it is on."""
    if not context.scene.tool_settings.use_keyframe_insert_auto:
        return False
    key(rig, bones, context.scene.frame_current_final)
    return True
