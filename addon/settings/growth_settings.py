# SPDX-License-Identifier: GPL-3.0-or-later
"""`object.sinew.skin.growth`: the options of Grow Skin, for the operator and for a grown skin, which keeps them."""

from bpy.props import BoolProperty, FloatProperty, IntProperty
from bpy.types import PropertyGroup

from .updates import OVERRIDABLE

FEWEST_FACES = 50


class GrowthOptions:
    """Mix-in with the options, for the operator and for the skin."""

    resolution: IntProperty(
        name="Resolution",
        description="Voxels along the longest side of the anatomy. Higher values show smaller muscles (Wilhelms 1997: 83)",
        default=83,
        min=4,
        max=8192,
        soft_max=512,
        override=OVERRIDABLE,
        options=set(),
    )
    thickness: FloatProperty(
        name="Thickness",
        description="Thickness of the skin over all tissues. Skin Thickness of a tissue is added to it",
        subtype="DISTANCE",
        min=0.0,
        soft_max=0.1,
        precision=4,
        override=OVERRIDABLE,
        options=set(),
    )
    smoothing: IntProperty(
        name="Smoothing",
        description="Passes of the filter that fills the creases between tissues. The filter never removes volume",
        default=5,
        min=0,
        max=100,
        soft_max=20,
        override=OVERRIDABLE,
        options=set(),
    )
    radius: IntProperty(
        name="Radius",
        description="Radius of the filter in voxels. Larger values fill wider creases",
        default=1,
        min=1,
        max=4,
        override=OVERRIDABLE,
        options=set(),
    )
    decay: FloatProperty(
        name="Decay",
        description="Rate at which the weights of the filter fall: e^(-decay · distance²), with the distance in voxels",
        default=1.0,
        min=0.0,
        soft_max=3.0,
        override=OVERRIDABLE,
        options=set(),
    )
    faces: IntProperty(
        name="Faces",
        description="Maximum number of faces. 0: as many as the resolution gives",
        default=0,
        min=0,
        soft_max=50000,
        override=OVERRIDABLE,
        options=set(),
    )
    symmetric: BoolProperty(
        name="Symmetric",
        description="Mirror the result exactly where the tissues are symmetric",
        default=True,
        override=OVERRIDABLE,
        options=set(),
    )
    largest_only: BoolProperty(
        name="Largest Piece Only",
        description="Keep only the largest connected piece",
        default=False,
        override=OVERRIDABLE,
        options=set(),
    )


class SinewGrowthSettings(GrowthOptions, PropertyGroup):
    """The options that a grown skin was grown with."""

    is_grown: BoolProperty(options={"HIDDEN"})


OPTIONS = tuple(GrowthOptions.__annotations__)
CLASSES = (SinewGrowthSettings,)


def copy(source, target, without=()):
    """Copies the options from a skin's settings to an operator, except those named in `without`."""
    for name in OPTIONS:
        if name not in without:
            setattr(target, name, getattr(source, name))
