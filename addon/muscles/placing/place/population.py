# SPDX-License-Identifier: GPL-3.0-or-later
"""A whole preset put on a rig, sized to lie under its skin."""

from ....scene.tissue_empty import TissueShape
from ... import edit
from ..fit import fit
from ..fit.skin_surface import SkinSurface
from ..recognise.segments import Body
from . import placement
from .preset_file import Preset


def populate(rig, preset: Preset, body: Body, skin, strands: str = placement.SEPARATE) -> list[TissueShape]:
    """Adds a preset's tissues to a rig that was recognised as `body` and returns them; those of the same names are replaced.

    skin: the mesh that they are fitted under, or None: then they have the usual sizes. Raises SinewError where the rig lacks
    what the preset needs; then nothing has changed.
    """
    surface = SkinSurface.of(skin, rig) if skin else None
    shapes = placement.place(preset, body, surface, strands)
    if surface:
        shapes = fit.fit_all(shapes, surface)
    edit.add(rig, shapes)
    return shapes
