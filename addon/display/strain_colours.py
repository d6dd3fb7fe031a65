# SPDX-License-Identifier: GPL-3.0-or-later
"""The heat map of a skin: a colour attribute that shows where edges are shorter (blue) or longer (red) than at rest."""

import numpy as np

ATTRIBUTE = "sinew_stretch"
FARTHEST = 2.0  # an edge of twice its rest length, or of half of it, has the full colour
SCALE = "blue: half the rest length and less, white: as at rest, red: twice and more"
_SHORTER, _AT_REST, _LONGER = np.array(((0.02, 0.08, 0.8), (0.9, 0.9, 0.9), (0.8, 0.02, 0.02)))


def show(mesh, stretch: np.ndarray):
    """Paints a mesh by (vertices,) float32: the length over rest length of the edge at each that changed most."""
    attribute = mesh.color_attributes.get(ATTRIBUTE)
    if attribute is None:
        attribute = mesh.color_attributes.new(ATTRIBUTE, "FLOAT_COLOR", "POINT")
    share = np.clip(np.log(stretch) / np.log(FARTHEST), -1.0, 1.0)[:, None]
    colours = np.ones((len(stretch), 4), np.float32)
    colours[:, :3] = _AT_REST + np.abs(share) * (np.where(share < 0.0, _SHORTER, _LONGER) - _AT_REST)
    attribute.data.foreach_set("color", colours.reshape(-1))
    mesh.color_attributes.active_color = attribute


def remove(mesh):
    """Takes the heat map away, where there is one."""
    attribute = mesh.color_attributes.get(ATTRIBUTE)
    if attribute and mesh.library is None:
        mesh.color_attributes.remove(attribute)
