# SPDX-License-Identifier: GPL-3.0-or-later
"""Sinew: muscles for Blender characters. This file only registers."""

from . import bone_properties, command_line, handlers, operators, properties, reach_properties, ui

_PARTS = (reach_properties, properties, bone_properties, operators, ui, handlers, command_line)


def register():
    for part in _PARTS:
        part.register()


def unregister():
    for part in reversed(_PARTS):
        part.unregister()
