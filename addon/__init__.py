# SPDX-License-Identifier: GPL-3.0-or-later
"""Sinew: muscles for Blender characters. This file only registers."""

from . import command_line, operators, ui
from .live import handlers
from .settings import bone_settings, goal_settings, object_settings

_PARTS = (goal_settings, object_settings, bone_settings, operators, ui, handlers, command_line)


def register():
    for part in _PARTS:
        part.register()


def unregister():
    for part in reversed(_PARTS):
        part.unregister()
