# SPDX-License-Identifier: GPL-3.0-or-later
"""Mute, Solo and Influence: which muscles act, and how much they swell."""


def left_out(tissues: list) -> set[int]:
    """The indices of the muscles that do not act: the muted ones, and all that are not solo if one is.

    Bones, stuffing and spheres always act. Solo takes precedence over Mute, as in Blender's animation editors.
    """
    muscles = {index: tissue.sinew.tissue for index, tissue in enumerate(tissues)}
    muscles = {index: settings for index, settings in muscles.items() if settings.kind == "MUSCLE"}
    solo = {index for index, settings in muscles.items() if settings.solo}
    return muscles.keys() - solo if solo else {index for index, settings in muscles.items() if settings.muted}


def influence_of(tissue) -> float:
    """The setting Influence of a muscle. 1 for other tissues, which do not swell."""
    settings = tissue.sinew.tissue
    return settings.influence if settings.kind == "MUSCLE" else 1.0
