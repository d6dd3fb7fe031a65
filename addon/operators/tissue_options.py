# SPDX-License-Identifier: GPL-3.0-or-later
"""Properties that the operators that add tissues share."""

from bpy.props import BoolProperty, EnumProperty, FloatProperty

from ..muscles.placing.place import figure

ALONG = FloatProperty(
    name="Along",
    description="Position of each attachment on its bone: 0 is the head, 1 is the tail. Wilhelms (1997) uses 0.1",
    min=0.0,
    max=1.0,
    default=0.1,
    subtype="FACTOR",
)
FIT_SKIN = BoolProperty(
    name="Fit under Skin", description="Resize the tissues so that they end just under the mesh", default=True
)
FIGURE = EnumProperty(
    name="Figure",
    description="How much muscle and fat the body has. The measured volumes of a preset are scaled by it",
    items=[(found.identifier, found.label, found.description) for found in figure.FIGURES.values()],
)
