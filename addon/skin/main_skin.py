# SPDX-License-Identifier: GPL-3.0-or-later
"""The mesh of a rig that its muscles are fitted to."""

from ..scene import characters
from . import grow


def main_skin_of(rig):
    """Returns the mesh of a rig with the most vertices, or None if none has faces.

    Grown skins do not count: they follow the muscles and so cannot size them.
    """
    modelled = (skin for skin in characters.skins_of(rig) if not grow.is_grown(skin))
    skins = [skin for skin in modelled if skin.data.polygons or skin.data.is_editmode]
    return max(skins, key=lambda skin: len(skin.data.vertices), default=None)
