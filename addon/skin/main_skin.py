# SPDX-License-Identifier: GPL-3.0-or-later
"""The meshes of a rig that its muscles are fitted to."""

from ..scene import characters, mesh_role
from . import grow


def skins_to_fit(rig) -> list:
    """The meshes of a rig that are skin or cloth and have faces. If all of its meshes are rigid, those.

    Grown skins do not count: they follow the muscles and so cannot size them.
    """
    modelled = (skin for skin in characters.skins_of(rig) if not grow.is_grown(skin))
    skins = [skin for skin in modelled if skin.data.polygons or skin.data.is_editmode]
    return mesh_role.soft_and_rigid(skins, rig)[0] or skins


def main_skin_of(rig):
    """The mesh of `skins_to_fit` with the most vertices, or None."""
    return max(skins_to_fit(rig), key=lambda skin: len(skin.data.vertices), default=None)
