# SPDX-License-Identifier: GPL-3.0-or-later
"""Removes what a frame derives, so that saved files hold none of it: corrections, shown poses, shaded muscles and views."""

import bpy
import numpy as np

from ..display import shaded, views
from ..scene import characters, correction_modifier, tissue_display
from ..settings import updates
from . import failures, session


def rest_skin(skin):
    """Sets the correction of a mesh to 0. The mesh is then what its other modifiers make of it."""
    mesh = skin.data
    correction = np.empty((len(mesh.vertices), 3), np.float32)
    if not mesh.is_editmode and correction_modifier.read_correction(mesh, correction) and correction.any():
        correction_modifier.write_correction(mesh, np.zeros_like(correction))


def rest_all():
    """Removes the corrections, shown poses, shaded muscles and views of all characters, until `show_views` and a frame."""
    for character in characters.in_file():
        for key, rest_object in (
            *((key, rest_skin) for key in character.skins),
            *((key, tissue_display.show_rest) for key in character.tissues),
            (character.rig, shaded.clear),
            (character.rig, views.rest),
        ):
            found = key.find()
            if found:
                with failures.isolated((key, "rest"), f"{key.name}: showing its rest pose"):
                    rest_object(found)
    session.forget_shown()


def show_views():
    """Shows the views of all characters after the file was saved or loaded, unless Sinew is off."""
    if not updates.is_enabled():
        return
    for character in characters.in_file():
        rig = character.rig.find()
        if rig and not rig.library:
            with failures.isolated((character.rig, "view"), f"{rig.name}: showing its view"):
                shaded.renew(rig)
                if views.of(rig) != views.SKIN:
                    views.apply(rig, bpy.context.view_layer)
