# SPDX-License-Identifier: GPL-3.0-or-later
"""How a skin is grown: what the operator asks for, and what a grown skin remembers, to be grown again alike."""

from bpy.props import BoolProperty, FloatProperty, IntProperty
from bpy.types import PropertyGroup

from .updates import OVERRIDABLE

FEWEST_FACES = 50


class GrowthOptions:
    """Mix-in with the options, for the operator and for the skin."""

    resolution: IntProperty(
        name="Resolution",
        description="Voxels along the longest side of the whole anatomy; 83 as in Wilhelms' paper, more shows finer muscles",
        default=83,
        min=4,
        max=8192,
        soft_max=512,
        override=OVERRIDABLE,
    )
    thickness: FloatProperty(
        name="Thickness",
        description="Thickness of the skin over all tissues; each tissue can have more of its own (Skin Thickness)",
        subtype="DISTANCE",
        min=0.0,
        soft_max=0.1,
        precision=4,
        override=OVERRIDABLE,
    )
    smoothing: IntProperty(
        name="Smoothing",
        description="Passes of the filter that fills the creases between tissues; it never takes anything away",
        default=5,
        min=0,
        max=100,
        soft_max=20,
        override=OVERRIDABLE,
    )
    radius: IntProperty(
        name="Radius",
        description="How far a pass looks, in voxels: wider fills wider creases",
        default=1,
        min=1,
        max=4,
        override=OVERRIDABLE,
    )
    decay: FloatProperty(
        name="Decay",
        description="How fast the filter's weights fall, e^(-decay · distance²) with the distance in voxels",
        default=1.0,
        min=0.0,
        soft_max=3.0,
        override=OVERRIDABLE,
    )
    faces: IntProperty(
        name="Faces",
        description="Most faces that the skin may have; 0: as many as the resolution gives",
        default=0,
        min=0,
        soft_max=50000,
        override=OVERRIDABLE,
    )
    symmetric: BoolProperty(
        name="Symmetric",
        description="Make left and right exactly alike wherever the tissues are",
        default=True,
        override=OVERRIDABLE,
    )
    largest_only: BoolProperty(
        name="Drop Islands",
        description="Keep only the largest of pieces that do not hang together",
        default=False,
        override=OVERRIDABLE,
    )


class SinewGrowth(GrowthOptions, PropertyGroup):
    """What a grown skin was grown with."""

    is_grown: BoolProperty(options={"HIDDEN"})


OPTIONS = tuple(GrowthOptions.__annotations__)


def copy(source, target, without=()):
    """Copies the options, but for some, from a skin's own to an operator."""
    for name in OPTIONS:
        if name not in without:
            setattr(target, name, getattr(source, name))
