# SPDX-License-Identifier: GPL-3.0-or-later
"""Sinew: muscles for Blender characters. This file only registers."""

from . import bone_properties, handlers, operators, properties, reach_properties, ui

_PARTS = (reach_properties, properties, bone_properties, operators, ui, handlers)


def register():
    for part in _PARTS:
        part.register()


def unregister():
    for part in reversed(_PARTS):
        part.unregister()
