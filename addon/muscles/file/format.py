# SPDX-License-Identifier: GPL-3.0-or-later
"""What writer and reader agree on."""

from ...scene import armature_modifier, characters

FORMAT = 1
GRID_OF_RIG_SIZE = 2.5e-6
# of the skin's settings, those that are no length; a file may lack the later ones
SKIN_SETTINGS = ("anchoring", "carry", "scale_fat", "gain", "elastic", "iterations")
LATER_SKIN_SETTINGS = ("energy", "anchor_stiffness", "edge_stiffness", "fat_sliding", "collides", "contacts")


def skins_of(rig) -> list:
    """The bound meshes of a rig, or all that follow it where none is bound."""
    found = characters.skins_of(rig)
    return [skin for skin in found if armature_modifier.is_bound(skin)] or found
