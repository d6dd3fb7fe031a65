# SPDX-License-Identifier: GPL-3.0-or-later
"""Sinew: muscles for Blender characters. This file registers the parts of the add-on."""

from . import command_line, operators, settings, ui
from .live import handlers

_PARTS = (settings, operators, ui, handlers, command_line)


def register():
    for part in _PARTS:
        part.register()


def unregister():
    for part in reversed(_PARTS):
        part.unregister()
