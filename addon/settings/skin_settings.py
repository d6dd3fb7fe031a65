# SPDX-License-Identifier: GPL-3.0-or-later
"""`object.sinew.skin`: the settings of a mesh that is bound to the muscles of its armature."""

import bpy
from bpy.props import (
    BoolProperty,
    CollectionProperty,
    EnumProperty,
    FloatProperty,
    IntProperty,
    PointerProperty,
    StringProperty,
)
from bpy.types import PropertyGroup

from ..scene import live_switch, skin_regions
from . import updates
from .growth_settings import SinewGrowthSettings
from .updates import OVERRIDABLE, characters_changed, setting_changed

ANCHORINGS = (
    ("BLENDED", "Blended", "Each vertex follows all tissues near it, the nearest most. No seams"),
    ("NEAREST", "Nearest", "Each vertex follows only its nearest tissue (Arabacı 2001)"),
)
ENERGIES = (
    (
        "AS_RIGID_AS_POSSIBLE",
        "As Rigid As Possible",
        "The neighborhood of each vertex can rotate but resists stretching (Sorkine and Alexa 2007)",
    ),
    ("SPRINGS", "Springs", "Each edge keeps its length (Wilhelms 1997)"),
)
DETAILS = (
    ("FULL", "Full", "Muscles, elastic skin and contact"),
    ("ANCHORS", "Not Elastic", "The skin follows bones and muscles, without elasticity and contact"),
    ("ARMATURE", "Armature Only", "The skin follows its Armature modifier alone"),
)
MOTION_SOURCES = (
    (
        "SWELLING",
        "Bone Weights + Muscle Swelling",
        "The mesh's bone weights move the skin. Tissues add their change of shape",
    ),
    ("FULL", "Muscles Only", "Tissues move the skin with their whole motion (Arabacı 2001, Wilhelms 1997)"),
)


def _regional(name: str, **settings):
    parameter = skin_regions.parameter_of(name)
    return FloatProperty(
        name=parameter.label,
        description=f"{parameter.description}. Factors of bones and painted factors multiply this value",
        min=0.0,
        update=setting_changed,
        override=OVERRIDABLE,
        **settings,
    )


def _live_changed(settings, _context):
    if not updates.is_silent():
        live_switch.show_live(settings.id_data)


def _is_other_mesh(settings, candidate) -> bool:
    return candidate.type == "MESH" and candidate != settings.id_data


class SinewBakedKey(PropertyGroup):
    """A shape key that Sinew baked, by its name, so that a new bake replaces it and Remove finds it.

    pose: as `joint_turns.text_of` writes it. muted_by_sinew: both bakes together would add up.
    """

    name: StringProperty(name="Name", description="Name of the shape key")
    joints: StringProperty(
        name="Joints", description="The bones that drive the key, one per line. Empty: the key of a frame"
    )
    pose: StringProperty(name="Pose", description="The pose in which a corrective is exact")
    muted_by_sinew: BoolProperty(
        name="Muted by Sinew", description="A later bake with another prefix plays instead", options=set()
    )


class SinewSkinSettings(PropertyGroup):
    """The settings of a skin."""

    bound: BoolProperty(
        name="Bound",
        description="The mesh is bound to the tissues of its armature",
        options={"HIDDEN"},
        update=characters_changed,
    )
    live: BoolProperty(
        name="Live",
        description="Deform the skin in every frame. Off: the mesh follows its Armature modifier, and baked keys play",
        default=True,
        update=_live_changed,
        override=OVERRIDABLE,
        options=set(),
    )
    anchoring: EnumProperty(
        name="Anchoring",
        description="Which tissues a vertex follows",
        items=ANCHORINGS,
        default="BLENDED",
        update=setting_changed,
        override=OVERRIDABLE,
    )
    motion_source: EnumProperty(
        name="Skin Motion",
        description="What moves a vertex. A mesh without bone weights always uses Muscles Only",
        items=MOTION_SOURCES,
        default="SWELLING",
        update=setting_changed,
        override=OVERRIDABLE,
    )
    scale_fat: BoolProperty(
        name="Scale Fat",
        description="The fat between muscle and skin swells with the muscle. Off: it keeps its thickness",
        update=setting_changed,
        override=OVERRIDABLE,
    )
    falloff: FloatProperty(
        name="Falloff",
        description="Distance from a tissue at which its influence ends. 0: a distance that fits the size of the armature",
        subtype="DISTANCE",
        min=0.0,
        soft_max=0.2,
        update=setting_changed,
        override=OVERRIDABLE,
    )
    muscle_influence: _regional("muscle_influence", default=1.0, soft_max=3.0)
    elastic: BoolProperty(
        name="Elastic",
        description="Relax the skin around joints that muscles cross, so that it keeps its shape and volume",
        default=True,
        update=setting_changed,
        override=OVERRIDABLE,
    )
    iterations: IntProperty(
        name="Iterations",
        description="Iterations of the relaxation per frame. Higher values are smoother and slower",
        min=0,
        max=100,
        soft_max=20,
        default=10,
        update=setting_changed,
        override=OVERRIDABLE,
    )
    render_iterations: IntProperty(
        name="Render Iterations",
        description="Iterations of the relaxation in renders and bakes. 0: as many as in the viewport",
        min=0,
        max=100,
        soft_max=20,
        options=set(),
        update=setting_changed,
        override=OVERRIDABLE,
    )
    viewport_detail: EnumProperty(
        name="Viewport Detail",
        description="How much of the skin is computed in the viewport. Bakes always have full detail",
        items=DETAILS,
        default="FULL",
        options=set(),
        update=setting_changed,
        override=OVERRIDABLE,
    )
    render_detail: EnumProperty(
        name="Render Detail",
        description="How much of the skin is computed in renders",
        items=DETAILS,
        default="FULL",
        options=set(),
        update=setting_changed,
        override=OVERRIDABLE,
    )
    elastic_distance: FloatProperty(
        name="Elastic Distance",
        description="Distance from the scene's camera beyond which the skin is not elastic. 0: at any distance it is",
        subtype="DISTANCE",
        min=0.0,
        options=set(),
        update=setting_changed,
        override=OVERRIDABLE,
    )
    muscle_distance: FloatProperty(
        name="Muscle Distance",
        description=(
            "Distance from the scene's camera beyond which the skin follows its Armature modifier alone. "
            "0: at any distance it follows the muscles"
        ),
        subtype="DISTANCE",
        min=0.0,
        options=set(),
        update=setting_changed,
        override=OVERRIDABLE,
    )
    energy: EnumProperty(
        name="Energy",
        description="What the relaxation of the skin keeps",
        items=ENERGIES,
        default="AS_RIGID_AS_POSSIBLE",
        update=setting_changed,
        override=OVERRIDABLE,
    )
    anchor_stiffness: _regional("anchor_stiffness", default=1.0, soft_max=5.0)
    edge_stiffness: _regional("edge_stiffness", default=1.0, soft_max=5.0)
    slack: _regional("slack", subtype="DISTANCE", soft_max=0.05)
    fat_sliding: _regional("fat_sliding", subtype="FACTOR", max=1.0)
    contacts: BoolProperty(
        name="Skin Contact",
        description="Keep skin from passing through other skin: an arm and the chest, a calf and the thigh",
        default=True,
        update=setting_changed,
        override=OVERRIDABLE,
    )
    safeguard: BoolProperty(
        name="Safeguard",
        description=(
            "Return a joint to the skin of the Armature modifier in rotations in which Sinew makes its skin worse. "
            "Each rotation is checked when a pose first comes near it"
        ),
        default=True,
        options=set(),
        update=setting_changed,
        override=OVERRIDABLE,
    )
    body_keys: StringProperty(
        name="Body Keys",
        description="The shape keys whose values form the rest body, one per line: those that were not 0 at Bind Skin",
        options={"HIDDEN"},
        override=OVERRIDABLE,
    )
    worn_over: PointerProperty(
        name="Worn Over",
        description="The bound mesh that this one is worn over. A garment follows it, with its distance from it",
        type=bpy.types.Object,
        poll=_is_other_mesh,
        update=setting_changed,
        override=OVERRIDABLE,
    )
    baked_keys: CollectionProperty(
        name="Baked Keys",
        description="The shape keys that Sinew baked",
        type=SinewBakedKey,
        options={"HIDDEN"},
        override={*OVERRIDABLE, "USE_INSERTION"},
    )
    cache_modifier: IntProperty(
        name="Cache Modifier",
        description="Persistent identifier of the Mesh Cache modifier that plays the baked point cache. 0: none",
        options={"HIDDEN"},
        override=OVERRIDABLE,
    )
    is_correction_hidden: BoolProperty(
        name="Correction Hidden",
        description="The mesh holds the correction of another object that shares it, which Sinew hides on this one",
        options={"HIDDEN"},
        override=OVERRIDABLE,
    )
    bake_error_mm: FloatProperty(
        name="Bake Error",
        description="Largest distance between the live skin and the last bake, in mm. -1: never baked",
        default=-1.0,
        options={"HIDDEN"},
    )
    corrective_summary: StringProperty(
        name="Correctives", description="Result of the last bake of correctives, one line per joint", options={"HIDDEN"}
    )
    quality_text: PointerProperty(
        name="Quality", description="Result of the last measurement", type=bpy.types.Text, options={"HIDDEN"}
    )
    quality_json: PointerProperty(
        name="Quality as JSON", description="The same for programs", type=bpy.types.Text, options={"HIDDEN"}
    )
    quality_summary: StringProperty(
        name="Quality Summary", description="The worst pose of the last measurement, in a few lines", options={"HIDDEN"}
    )
    growth: PointerProperty(
        name="Growth",
        description="How a grown skin was grown",
        type=SinewGrowthSettings,
        options={"HIDDEN"},
        override=OVERRIDABLE,
    )


CLASSES = (SinewBakedKey, SinewSkinSettings)
