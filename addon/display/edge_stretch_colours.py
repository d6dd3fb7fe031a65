# SPDX-License-Identifier: GPL-3.0-or-later
"""The heat map of a skin: a color attribute that shows where edges are shorter (blue) or longer (red) than at rest."""

import numpy as np

ATTRIBUTE = "sinew_stretch"
FULL_COLOUR_STRETCH = 2.0  # an edge of twice or half its rest length has the full color
SCALE = "blue: half the rest length and less, white: as at rest, red: twice and more"
_SHORTER, _AT_REST, _LONGER = np.array(((0.02, 0.08, 0.8), (0.9, 0.9, 0.9), (0.8, 0.02, 0.02)))


def show(mesh, stretch: np.ndarray):
    """Colors a mesh. stretch: (vertices,) float32, length over rest length of the most stretched edge at each vertex."""
    attribute = mesh.color_attributes.get(ATTRIBUTE)
    if attribute is None:
        attribute = mesh.color_attributes.new(ATTRIBUTE, "FLOAT_COLOR", "POINT")
    blend = np.clip(np.log(stretch) / np.log(FULL_COLOUR_STRETCH), -1.0, 1.0)[:, None]
    colours = np.ones((len(stretch), 4), np.float32)
    colours[:, :3] = _AT_REST + np.abs(blend) * (np.where(blend < 0.0, _SHORTER, _LONGER) - _AT_REST)
    attribute.data.foreach_set("color", colours.reshape(-1))
    mesh.color_attributes.active_color = attribute


def remove(mesh):
    """Removes the heat map, if the mesh has one."""
    attribute = mesh.color_attributes.get(ATTRIBUTE)
    if attribute and mesh.library is None:
        mesh.color_attributes.remove(attribute)
