# SPDX-License-Identifier: GPL-3.0-or-later
"""What a person sets for a skin: the part of `object.sinew` that counts on meshes."""

from bpy.props import BoolProperty, CollectionProperty, EnumProperty, FloatProperty, IntProperty, StringProperty
from bpy.types import PropertyGroup

from ..scene import live_switch, skin_regions
from .updates import OVERRIDABLE, characters_changed, setting_changed

ANCHORINGS = (
    ("BLENDED", "Blended", "Each vertex follows all tissues near it, the nearest most; no seams"),
    ("NEAREST", "Nearest", "Each vertex follows its nearest tissue alone, as in the 2001 thesis"),
)
ENERGIES = (
    (
        "AS_RIGID_AS_POSSIBLE",
        "As Rigid As Possible",
        "Skin keeps its shape around each vertex, turned as it may be (Sorkine and Alexa 2007)",
    ),
    ("SPRINGS", "Springs", "Skin keeps the length of each edge, as in Wilhelms' work of 1997"),
)
CARRIES = (
    ("SWELLING", "Swelling", "The mesh's own bone weights carry the skin; tissues add their change of shape"),
    ("FULL", "Full", "Tissues carry the skin with all of their motion, as in the papers"),
)


def _regional(name: str, **settings):
    parameter = skin_regions.parameter_of(name)
    return FloatProperty(
        name=parameter.label,
        description=f"{parameter.description}. Bones and painted vertices can differ: their factors multiply this",
        min=0.0,
        update=setting_changed,
        override=OVERRIDABLE,
        **settings,
    )


def _live_changed(settings, _context):
    live_switch.show_live(settings.id_data)


class SinewBakedKey(PropertyGroup):
    """The name of a shape key that Sinew baked, so that a new bake replaces it and Remove finds it.

    joints: the bones that drive it, one a line; empty for a key of a frame.
    pose: for a corrective, where it is exact, as `motions.text_of` has it.
    silenced: a later bake with another prefix plays in its place; both together would add up.
    """

    name: StringProperty()
    joints: StringProperty()
    pose: StringProperty()
    silenced: BoolProperty()


class SkinSettings:
    """Mix-in: the settings of a skin."""

    bound: BoolProperty(options={"HIDDEN"}, update=characters_changed)
    live: BoolProperty(
        name="Live",
        description="Deform the skin in every frame; off: the mesh follows its Armature modifier alone, and baked keys play",
        default=True,
        update=_live_changed,
        override=OVERRIDABLE,
    )
    anchoring: EnumProperty(
        name="Anchoring",
        description="Which tissues a vertex follows",
        items=ANCHORINGS,
        default="BLENDED",
        update=setting_changed,
        override=OVERRIDABLE,
    )
    carry: EnumProperty(
        name="Carry",
        description="What a vertex takes from its tissues. A mesh without bone weights is always carried in full",
        items=CARRIES,
        default="SWELLING",
        update=setting_changed,
        override=OVERRIDABLE,
    )
    scale_fat: BoolProperty(
        name="Scale Fat",
        description="Let the fat between muscle and skin swell with the muscle; off: it keeps its thickness",
        update=setting_changed,
        override=OVERRIDABLE,
    )
    reach: FloatProperty(
        name="Reach",
        description="Distance from a tissue at which its influence has faded out; 0 chooses by the size of the rig",
        subtype="DISTANCE",
        min=0.0,
        soft_max=0.2,
        update=setting_changed,
        override=OVERRIDABLE,
    )
    gain: FloatProperty(
        name="Gain",
        description="How strongly swelling shows on the skin; 1 is true to scale",
        min=0.0,
        soft_max=3.0,
        default=1.0,
        update=setting_changed,
        override=OVERRIDABLE,
    )
    elastic: BoolProperty(
        name="Elastic",
        description="Relax the skin around the joints that muscles cross, so that it keeps its shape and volume there",
        default=True,
        update=setting_changed,
        override=OVERRIDABLE,
    )
    iterations: IntProperty(
        name="Iterations",
        description="Rounds of relaxation in every frame: more is smoother and slower",
        min=0,
        max=100,
        soft_max=20,
        default=10,
        update=setting_changed,
        override=OVERRIDABLE,
    )
    energy: EnumProperty(
        name="Energy",
        description="What the skin keeps as it is relaxed",
        items=ENERGIES,
        default="AS_RIGID_AS_POSSIBLE",
        update=setting_changed,
        override=OVERRIDABLE,
    )
    anchor_stiffness: _regional("anchor_stiffness", default=1.0, soft_max=5.0)
    edge_stiffness: _regional("edge_stiffness", default=1.0, soft_max=5.0)
    rest_distance: _regional("rest_distance", subtype="DISTANCE", soft_max=0.05)
    fat_sliding: _regional("fat_sliding", subtype="FACTOR", max=1.0)
    collides: BoolProperty(
        name="Collide with Tissues",
        description=(
            "Keep the skin from sinking deeper into the bones and muscles that it lies on than it is at rest. "
            "Ellipsoids that come out of their place in a far pose push the skin with them: for poses that were looked at"
        ),
        default=False,
        update=setting_changed,
        override=OVERRIDABLE,
    )
    contacts: BoolProperty(
        name="Skin Contact",
        description="Keep skin off other skin: an arm off the chest, a calf off the thigh",
        default=True,
        update=setting_changed,
        override=OVERRIDABLE,
    )
    baked_keys: CollectionProperty(type=SinewBakedKey, options={"HIDDEN"})
    cache_modifier: IntProperty(
        name="Cache Modifier",
        description="Which Mesh Cache modifier plays the baked point cache, by its persistent identifier; 0: none",
        options={"HIDDEN"},
        override=OVERRIDABLE,
    )
    bake_error_mm: FloatProperty(
        name="Bake Error",
        description="Largest distance between the live skin and the last bake, in mm; -1: never baked",
        default=-1.0,
        options={"HIDDEN"},
    )
    corrective_summary: StringProperty(
        name="Correctives", description="What the last bake of correctives found, a line for each joint", options={"HIDDEN"}
    )
