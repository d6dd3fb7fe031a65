# SPDX-License-Identifier: GPL-3.0-or-later
"""A whole preset put on a rig, sized to lie under its skin."""

from .. import musculature
from ..tissue_io import TissueShape
from . import fit, placement
from .preset_file import Preset
from .segments import Body
from .skin_surface import SkinSurface


def populate(rig, preset: Preset, body: Body, skin, strands: str = placement.SEPARATE) -> list[TissueShape]:
    """Adds a preset's tissues to a rig that was recognised as `body` and returns them; those of the same names are replaced.

    skin: the mesh that they are fitted under, or None: then they have the usual sizes. Raises SinewError where the rig lacks
    what the preset needs; then nothing has changed.
    """
    surface = SkinSurface.of(skin, rig) if skin else None
    shapes = placement.place(preset, body, surface, strands)
    if surface:
        shapes = fit.fit_all(shapes, surface)
    musculature.add(rig, shapes)
    return shapes
