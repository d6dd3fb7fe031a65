# SPDX-License-Identifier: GPL-3.0-or-later
"""Adding a whole preset to a rig, sized to fit under its skin."""

from ....scene.tissue_empty import TissueShape
from ... import edit
from ..fit import fit
from ..fit.skin_surface import SkinSurface
from ..recognise.body import Body
from . import placement
from .preset_file import Preset


def populate(rig, preset: Preset, body: Body, skins: list, strands: str = placement.SEPARATE) -> list[TissueShape]:
    """Adds a preset's tissues to a rig and returns them. They replace tissues of the same names.

    body: the result of recognising the rig. skins: the meshes that the tissues are fitted under; without any they get the
    usual sizes. Raises SinewError if the rig lacks a part that the preset needs. In that case nothing is changed.
    """
    surface = SkinSurface.of_all(skins, rig) if skins else None
    shapes = placement.place(preset, body, surface, strands)
    if surface:
        shapes = fit.fit_all(shapes, surface)
    edit.add(rig, shapes)
    return shapes
