# SPDX-License-Identifier: GPL-3.0-or-later
"""`object.sinew.tissue`: the settings of the Empty of a tissue or of a via point."""

import bpy
from bpy.props import (
    BoolProperty,
    CollectionProperty,
    EnumProperty,
    FloatProperty,
    FloatVectorProperty,
    IntProperty,
    PointerProperty,
    StringProperty,
)
from bpy.types import PropertyGroup

from ..scene import stored_settings, tissue_bones, tissue_empty, tissue_size
from .updates import OVERRIDABLE, characters_changed, setting_changed

TISSUE_KINDS = (
    ("MUSCLE", "Muscle", "A belly between two tendons. It shortens and lengthens at constant volume"),
    ("BONE", "Bone", "Three rigid ellipsoids along a bone: a shaft and two ends"),
    ("STUFFING", "Stuffing", "One rigid ellipsoid, for fat, organs, a head or a hand"),
    ("SPHERE", "Sphere", "A rigid ball at a joint"),
)
VIA_KIND = ("VIA", "Via Point", "A point on a bone that a muscle passes between its origin and its insertion")


def _is_muscle(via, candidate) -> bool:
    return _is_neighbour(via, candidate, "MUSCLE")


def _is_sphere(wrap, candidate) -> bool:
    return _is_neighbour(wrap, candidate, "SPHERE")


def _is_neighbour(settings, candidate, kind: str) -> bool:
    is_tissue = tissue_empty.is_tissue(candidate) and stored_settings.tissue_of(candidate).kind == kind
    return is_tissue and candidate.parent == settings.id_data.parent


class SinewWrap(PropertyGroup):
    """A sphere that a muscle wraps around. A pointer survives renaming, duplicating and appending."""

    sphere: PointerProperty(
        name="Sphere",
        description="The joint sphere that the muscle wraps around",
        type=bpy.types.Object,
        poll=_is_sphere,
        update=setting_changed,
        override=OVERRIDABLE,
    )


class SinewTissueSettings(PropertyGroup):
    """The settings of a tissue or a via point."""

    kind: EnumProperty(
        name="Kind",
        description="What the Empty represents",
        items=(("NONE", "None", "Not a tissue"), *TISSUE_KINDS, VIA_KIND),
        default="NONE",
        update=characters_changed,
        override=OVERRIDABLE,
        options=set(),
    )
    origin_bone: StringProperty(
        name="Origin Bone",
        description="The bone that the tissue is attached to. A muscle has its origin on this bone",
        get=tissue_bones.origin_bone,
        set=tissue_bones.set_origin_bone,
        update=setting_changed,
    )
    insertion_bone: StringProperty(
        name="Insertion Bone",
        description="The bone that the muscle pulls. It has its insertion on this bone",
        get=tissue_bones.insertion_bone,
        set=tissue_bones.set_insertion_bone,
        update=setting_changed,
    )
    origin_tendon: FloatProperty(
        name="Origin Tendon",
        description="Length of the tendon between origin and belly. It stays the same in every pose",
        subtype="DISTANCE",
        min=0.0,
        soft_max=0.5,
        update=setting_changed,
        override=OVERRIDABLE,
    )
    insertion_tendon: FloatProperty(
        name="Insertion Tendon",
        description="Length of the tendon between belly and insertion. It stays the same in every pose",
        subtype="DISTANCE",
        min=0.0,
        soft_max=0.5,
        update=setting_changed,
        override=OVERRIDABLE,
    )
    volume_keeping: FloatProperty(
        name="Volume Keeping",
        description="How much the belly widens when it shortens. 1: keeps its volume exactly. 0: keeps its widths",
        min=0.0,
        max=1.5,
        default=1.0,
        subtype="FACTOR",
        update=setting_changed,
        override=OVERRIDABLE,
    )
    tension: FloatProperty(
        name="Tension",
        description=(
            "Tenses the muscle at constant length: the belly becomes shorter and thicker. Can be keyed or driven. "
            "In a muscle that is disabled in viewports, keys still act and drivers do not"
        ),
        min=0.0,
        max=1.0,
        subtype="FACTOR",
        update=setting_changed,
        override=OVERRIDABLE,
    )
    influence: FloatProperty(
        name="Influence",
        description="How much the muscle swells. 1: fully. 0: its belly keeps its widths in every pose",
        min=0.0,
        max=1.0,
        default=1.0,
        subtype="FACTOR",
        options=set(),
        update=setting_changed,
        override=OVERRIDABLE,
    )
    muted: BoolProperty(
        name="Mute",
        description="Leave the muscle out: the skin is bound to the other tissues",
        options=set(),
        update=setting_changed,
        override=OVERRIDABLE,
    )
    solo: BoolProperty(
        name="Solo",
        description="Leave out all muscles of the armature that are not solo",
        options=set(),
        update=setting_changed,
        override=OVERRIDABLE,
    )
    group: StringProperty(
        name="Group",
        description="Name of the group that the tissue belongs to, such as Arm.L. Groups can be edited together",
        override=OVERRIDABLE,
    )
    semi_axes: FloatVectorProperty(
        name="Semi-Axes",
        description="Half of the belly's two widths and of its length. The same as the scale of the Empty",
        subtype="XYZ",
        unit="LENGTH",
        size=3,
        min=1e-5,
        soft_max=1.0,
        precision=4,
        options=set(),
        get=tissue_size.semi_axes,
        set=tissue_size.set_semi_axes,
        update=setting_changed,
    )
    width_ratio: FloatProperty(
        name="Width Ratio",
        description="Width of the belly along local X divided by its width along local Y. The cross-section keeps its area",
        min=0.01,
        soft_min=0.2,
        soft_max=5.0,
        max=100.0,
        options=set(),
        get=tissue_size.width_ratio,
        set=tissue_size.set_width_ratio,
        update=setting_changed,
    )
    offset: FloatProperty(
        name="Offset",
        description="Distance of the belly's center from the line of its origin bone, in the rest pose",
        subtype="DISTANCE",
        min=0.0,
        soft_max=0.5,
        precision=4,
        options=set(),
        get=tissue_size.offset,
        set=tissue_size.set_offset,
        update=setting_changed,
    )
    skin_thickness: FloatProperty(
        name="Skin Thickness",
        description="Thickness that is added to a grown skin over this tissue. Takes effect when the skin is grown again",
        subtype="DISTANCE",
        min=0.0,
        soft_max=0.1,
        precision=4,
        override=OVERRIDABLE,
        options=set(),
    )
    wraps: CollectionProperty(
        name="Wraps",
        description="The spheres that the muscle wraps around",
        type=SinewWrap,
        override={*OVERRIDABLE, "USE_INSERTION"},
    )
    muscle: PointerProperty(
        name="Muscle",
        description="The muscle whose path passes through this via point",
        type=bpy.types.Object,
        poll=_is_muscle,
        update=characters_changed,
        override=OVERRIDABLE,
    )
    order: IntProperty(
        name="Order",
        description="Position of the via point along the muscle. The muscle passes its via points in ascending order",
        update=setting_changed,
        override=OVERRIDABLE,
        options=set(),
    )
    name_in_files: StringProperty(
        name="Name in Files",
        description="The name that the tissue was made with. Blender numbers its object if another character has the name",
        options={"HIDDEN"},
    )
    disabled_by_layer: BoolProperty(
        name="Disabled by Layer",
        description="The muscle display disabled the Empty in viewports, not the user",
        options={"HIDDEN"},
        override=OVERRIDABLE,
    )


CLASSES = (SinewWrap, SinewTissueSettings)
