# SPDX-License-Identifier: GPL-3.0-or-later
"""The folder of this user that Blender gives the extension. It stays when the extension is updated."""

from pathlib import Path

import bpy

# the package of the extension, above this room
PACKAGE = __package__.rpartition(".")[0]


def folder(name: str) -> Path:
    """A folder inside it. It is created if it is missing. Raises OSError if that fails."""
    return Path(bpy.utils.extension_path_user(PACKAGE, path=name, create=True))
