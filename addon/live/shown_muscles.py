# SPDX-License-Identifier: GPL-3.0-or-later
"""What the shaded muscles of a rig show in a frame: the ellipsoids of the layers that are on, tendons, and their colours."""

import numpy as np

from ..display import anatomy_colours, ellipsoid_nodes, shaded, stretch_colours, visibility
from . import attachments, ellipsoids
from .rig_cache import RigState


def show(rig, state: RigState, solved: list, shaded_muscles):
    """Shows the tissues of a rig as shaded muscles. solved: the Empties of `state.solved`."""
    posed = ellipsoids.of(state)
    settings = rig.sinew.rig
    layers = visibility.shown_kinds(rig)
    kinds = [empty.sinew.tissue.kind for empty in solved]
    shown = np.array([kind in layers for kind in kinds])[posed.owners]
    matrices = posed.matrices[shown]
    if settings.colours == "STRETCH":
        shaded.show(shaded_muscles, matrices, stretch_colours.steps_of(posed.stretch[shown]))
        return
    colours = anatomy_colours.numbers_of(kinds)
    if settings.chosen:
        colours[[empty.name == settings.chosen for empty in solved]] = anatomy_colours.CHOSEN
    colours = colours[posed.owners][shown]
    if "MUSCLE" in layers:
        tubes = attachments.tendons_of(rig, state)
        matrices = np.concatenate((matrices, tubes))
        colours = np.concatenate((colours, np.full(len(tubes), anatomy_colours.TENDON, np.int32)))
    shaded.show(shaded_muscles, matrices, ellipsoid_nodes.FIRST_OF_ANATOMY + colours)
