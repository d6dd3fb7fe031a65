# SPDX-License-Identifier: GPL-3.0-or-later
"""One frame: from the evaluated pose to the shown tissues and the corrections of the skins.

A frame is a function of what stands in the file and the pose alone. It is the same code for viewport, render, bake and
command line; `depsgraph` says which evaluation it is for.
"""

import numpy as np

from ..display import shaded
from ..scene import characters, correction_modifier, tissue_display
from . import session


def rest_skin(skin):
    """Takes the correction away, so that the mesh is as its own modifiers leave it."""
    mesh = skin.data
    present = np.empty((len(mesh.vertices), 3), np.float32)
    if not mesh.is_editmode and correction_modifier.read_correction(mesh, present) and present.any():
        correction_modifier.write_correction(mesh, np.zeros_like(present))


def rest_all():
    """Takes all corrections and shown poses away: what is written to a file is what the person made, nothing derived."""
    for character in characters.in_file():
        for key in character.skins:
            skin = key.find()
            if skin:
                rest_skin(skin)
        for key in character.tissues:
            empty = key.find()
            if empty:
                tissue_display.show_rest(empty)
        rig = character.rig.find()
        if rig:
            shaded.clear(rig)
    session.forget_shown()
