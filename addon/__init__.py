# SPDX-License-Identifier: GPL-3.0-or-later
"""Sinew: muscles for Blender characters. This file registers the parts of the add-on."""

import logging

from . import command_line, operators, settings, ui
from .files import log
from .languages import tables
from .live import handlers
from .settings import preferences

_PARTS = (tables, settings, operators, ui, handlers, command_line)


def register():
    log.start()
    for part in _PARTS:
        part.register()
    preferences.apply()


def unregister():
    """Unregisters all parts. An error in one does not stop the others."""
    for part in reversed(_PARTS):
        try:
            part.unregister()
        except Exception:
            logging.getLogger("sinew").exception("Unregistering %s failed; the other parts are unregistered", part.__name__)
    log.stop()
