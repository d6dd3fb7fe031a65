# SPDX-License-Identifier: GPL-3.0-or-later
"""Adding a whole preset to a rig, sized to fit under its skin."""

from ....scene import characters, stored_settings
from ....scene.tissue_empty import TissueShape
from ... import edit
from ..fit import fit
from ..fit.skin_surface import SkinSurface
from ..recognise.body import Body
from ..recognise.kind import HUMAN
from . import placement
from .figure import AVERAGE, Figure, goals
from .preset_file import Preset

SMALLEST_OF_BODY = 2e-5  # volume of stuffing over that of the body, below which there is no room for it: 1.5 cm3 of a person


def populate(
    rig, preset: Preset, body: Body, skins: list, strands: str = placement.SEPARATE, figure: Figure = AVERAGE
) -> list[TissueShape]:
    """Adds a preset's tissues to a rig and returns them. They replace tissues of the same names.

    body: the result of recognising the rig. skins: the meshes that the tissues are fitted under; without any they get the
    usual sizes. figure: how much muscle and fat, for a preset that fills the body; its stuffing is left out where there is
    no room. On an animal, tissues that the mesh does not cover are left out: wings and fins can be thinner than any
    muscle. Raises SinewError if the rig lacks a part that the preset needs. In that case nothing is changed.
    """
    surface = SkinSurface.of_all(skins, rig) if skins else None
    shapes = placement.place(preset, body, surface, strands)
    if surface:
        shapes = fit.fit_all(shapes, surface)
        if preset.fills:
            body_m3 = surface.core.volume
            shapes = fit.fill_all(shapes, surface, *goals(preset, shapes, body_m3, figure))
            shapes = [shape for shape in shapes if shape.kind != "STUFFING" or shape.volume > SMALLEST_OF_BODY * body_m3]
        if preset.creature not in ("", HUMAN):
            modelled = (found for found in characters.skins_of(rig) if not stored_settings.is_grown(found))
            meshes = [found for found in modelled if found.data.polygons and not found.data.is_editmode]
            whole = SkinSurface.of_all(meshes, rig)
            shapes = placement.with_existing_wraps([shape for shape in shapes if whole.is_inside(shape.centre)])
    edit.add(rig, shapes)
    return shapes
