# SPDX-License-Identifier: GPL-3.0-or-later
"""The parts of the musculature file format that writer and reader share."""

from ...scene import armature_modifier, characters

FORMAT = 1
GRID_OF_RIG_SIZE = 2.5e-6  # grid of rounded lengths, as a fraction of the rig's size
# Settings of the skin that are not lengths. A file may lack the later ones.
SKIN_SETTINGS = ("anchoring", "carry", "scale_fat", "gain", "elastic", "iterations")
LATER_SKIN_SETTINGS = ("energy", "anchor_stiffness", "edge_stiffness", "fat_sliding", "collides", "contacts")


def skins_of(rig) -> list:
    """The bound meshes of a rig, or all meshes that follow it if none is bound."""
    skins = characters.skins_of(rig)
    return [skin for skin in skins if armature_modifier.is_bound(skin)] or skins
