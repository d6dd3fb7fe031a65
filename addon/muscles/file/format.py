# SPDX-License-Identifier: GPL-3.0-or-later
"""The parts of the musculature file format that writer and reader share."""

from ...scene import armature_modifier, characters

FORMAT = 2
FORMAT_0_1 = 1  # of Sinew 0.1, with other names for some settings
GRID_OF_RIG_SIZE = 2.5e-6  # grid of rounded lengths, as a fraction of the rig's size
# Settings of the skin that are not lengths. A file may lack the later ones.
SKIN_SETTINGS = ("anchoring", "motion_source", "scale_fat", "muscle_influence", "elastic", "iterations")
LATER_SKIN_SETTINGS = ("energy", "anchor_stiffness", "edge_stiffness", "fat_sliding", "contacts", "safeguard")
# Switches of earlier versions. A file may have them; they have no effect.
FORMER_SKIN_SWITCHES = ("collides",)
NAMES_0_1 = {
    "motion_source": "carry",
    "muscle_influence": "gain",
    "falloff": "reach",
    "slack": "rest_distance",
}


def skins_of(rig) -> list:
    """The bound meshes of a rig, or all meshes that follow it if none is bound."""
    skins = characters.skins_of(rig)
    return [skin for skin in skins if armature_modifier.is_bound(skin)] or skins
