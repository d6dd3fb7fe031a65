# SPDX-License-Identifier: GPL-3.0-or-later
"""What a person sets, kept in Blender's own data: `object.sinew` on Empties (tissues), meshes and armatures.

These names are a stable surface: scripts and presets rely on them.
"""

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

from . import attachment_bones, belly, growth_settings, mesh_io, musculature, roster, selection, session, tissue_io
from .layers import shaded, visibility

TISSUE_KINDS = (
    ("MUSCLE", "Muscle", "A belly between two tendons: it shortens, lengthens and bulges at constant volume"),
    ("BONE", "Bone", "Three ellipsoids along a bone: a shaft and two ends; rigid"),
    ("STUFFING", "Stuffing", "One rigid ellipsoid, for fat, organs, a head, a hand"),
    ("SPHERE", "Sphere", "A ball at a joint that never bulges"),
)
VIA_KIND = ("VIA", "Via Point", "A place on a bone that a muscle passes between its origin and its insertion")
ANCHORINGS = (
    ("BLENDED", "Blended", "Each vertex follows all tissues near it, the nearest most; no seams"),
    ("NEAREST", "Nearest", "Each vertex follows its nearest tissue alone, as in the 2001 thesis"),
)
CARRIES = (
    ("SWELLING", "Swelling", "The mesh's own bone weights carry the skin; tissues add their change of shape"),
    ("FULL", "Full", "Tissues carry the skin with all of their motion, as in the papers"),
)


def _roster_changed(_settings, _context):
    roster.forget()


def _setting_changed(settings, _context):
    settings.id_data.update_tag()  # Blender reports the object, and the next frame reads the setting


def _live_changed(settings, _context):
    mesh_io.show_live(settings.id_data)


def _show_shaded(settings) -> bool:
    return shaded.find(settings.id_data) is not None


def _set_show_shaded(settings, shown: bool):
    rig = settings.id_data
    if not shown:
        shaded.remove(rig)
    elif shaded.find(rig) is None:
        shaded.create(rig, musculature.collection_of(rig))
    roster.forget()


def _layers_changed(settings, context):
    rig = settings.id_data
    visibility.apply(rig, [*roster.tissues_of(rig), *roster.vias_of(rig)], context.view_layer)
    session.forget_shown()  # what was hidden has not followed
    rig.update_tag()


def _is_muscle(via, candidate) -> bool:
    return _is_neighbour(via, candidate, "MUSCLE")


def _is_sphere(wrap, candidate) -> bool:
    return _is_neighbour(wrap, candidate, "SPHERE")


def _is_neighbour(settings, candidate, kind: str) -> bool:
    is_tissue = tissue_io.is_tissue(candidate) and candidate.sinew.kind == kind
    return is_tissue and candidate.parent == settings.id_data.parent


class SinewWrap(PropertyGroup):
    """A sphere that a muscle goes round; a pointer, so that it survives renaming, duplicating and appending."""

    sphere: PointerProperty(
        name="Sphere",
        description="The joint sphere that the muscle goes round",
        type=bpy.types.Object,
        poll=_is_sphere,
        update=_setting_changed,
    )


class SinewBakedKey(PropertyGroup):
    """The name of a shape key that Sinew baked, so that a new bake replaces it and Remove finds it.

    silenced: a later bake with another prefix plays in its place; both together would add up.
    """

    name: StringProperty()
    silenced: BoolProperty()


class SinewSettings(PropertyGroup):
    """Sinew's settings of one object; which of them count depends on its type."""

    # tissues (Empties)
    kind: EnumProperty(
        name="Kind",
        description="What the Empty stands for",
        items=(("NONE", "None", "Not a tissue"), *TISSUE_KINDS, VIA_KIND),
        default="NONE",
        update=_roster_changed,
    )
    origin_bone: StringProperty(
        name="Origin Bone",
        description="The bone that carries the tissue; a muscle's origin lies on it",
        get=attachment_bones.origin_bone,
        set=attachment_bones.set_origin_bone,
    )
    insertion_bone: StringProperty(
        name="Insertion Bone",
        description="The bone that the muscle pulls; its insertion lies on it",
        get=attachment_bones.insertion_bone,
        set=attachment_bones.set_insertion_bone,
    )
    origin_tendon: FloatProperty(
        name="Origin Tendon",
        description="Length of the tendon between origin and belly; it keeps this length in every pose",
        subtype="DISTANCE",
        min=0.0,
        soft_max=0.5,
        update=_setting_changed,
    )
    insertion_tendon: FloatProperty(
        name="Insertion Tendon",
        description="Length of the tendon between belly and insertion; it keeps this length in every pose",
        subtype="DISTANCE",
        min=0.0,
        soft_max=0.5,
        update=_setting_changed,
    )
    volume_keeping: FloatProperty(
        name="Volume Keeping",
        description="How much a belly widens as it shortens: 1 keeps its volume exactly, 0 keeps its widths",
        min=0.0,
        max=1.5,
        default=1.0,
        subtype="FACTOR",
        update=_setting_changed,
    )
    tension: FloatProperty(
        name="Tension",
        description=(
            "Tenses the muscle at unchanged length: the belly draws together and thickens. Can be keyed or driven; "
            "keys also act while the muscle is disabled in viewports, drivers then rest"
        ),
        min=0.0,
        max=1.0,
        subtype="FACTOR",
        update=_setting_changed,
    )
    semi_axes: FloatVectorProperty(
        name="Semi-Axes",
        description="Half of the belly's two widths and of its length; the same as the Empty's scale",
        subtype="XYZ",
        unit="LENGTH",
        size=3,
        min=1e-5,
        soft_max=1.0,
        precision=4,
        options=set(),
        get=belly.semi_axes,
        set=belly.set_semi_axes,
    )
    width_ratio: FloatProperty(
        name="Width Ratio",
        description="The belly's width along its local X over that along Y; its cross-section keeps its area",
        min=0.01,
        soft_min=0.2,
        soft_max=5.0,
        max=100.0,
        options=set(),
        get=belly.width_ratio,
        set=belly.set_width_ratio,
    )
    offset: FloatProperty(
        name="Offset",
        description="Distance of the belly's centre from the line of its origin bone, in the rest pose",
        subtype="DISTANCE",
        min=0.0,
        soft_max=0.5,
        precision=4,
        options=set(),
        get=belly.offset,
        set=belly.set_offset,
    )
    skin_thickness: FloatProperty(
        name="Skin Thickness",
        description="How much thicker than elsewhere a grown skin is over this tissue; counts when the skin is grown again",
        subtype="DISTANCE",
        min=0.0,
        soft_max=0.1,
        precision=4,
    )
    wraps: CollectionProperty(name="Wraps", description="The spheres that the muscle goes round", type=SinewWrap)

    # via points (Empties)
    muscle: PointerProperty(
        name="Muscle",
        description="The muscle that passes here",
        type=bpy.types.Object,
        poll=_is_muscle,
        update=_roster_changed,
    )
    order: IntProperty(
        name="Order",
        description="Where along the muscle: it passes its via points in rising order",
        update=_setting_changed,
    )

    # skins (meshes)
    bound: BoolProperty(options={"HIDDEN"}, update=_roster_changed)
    live: BoolProperty(
        name="Live",
        description="Deform the skin in every frame; off: the mesh follows its Armature modifier alone, and baked keys play",
        default=True,
        update=_live_changed,
    )
    anchoring: EnumProperty(
        name="Anchoring",
        description="Which tissues a vertex follows",
        items=ANCHORINGS,
        default="BLENDED",
        update=_setting_changed,
    )
    carry: EnumProperty(
        name="Carry",
        description="What a vertex takes from its tissues. A mesh without bone weights is always carried in full",
        items=CARRIES,
        default="SWELLING",
        update=_setting_changed,
    )
    scale_fat: BoolProperty(
        name="Scale Fat",
        description="Let the fat between muscle and skin swell with the muscle; off: it keeps its thickness",
        update=_setting_changed,
    )
    reach: FloatProperty(
        name="Reach",
        description="Distance from a tissue at which its influence has faded out; 0 chooses by the size of the rig",
        subtype="DISTANCE",
        min=0.0,
        soft_max=0.2,
        update=_setting_changed,
    )
    gain: FloatProperty(
        name="Gain",
        description="How strongly swelling shows on the skin; 1 is true to scale",
        min=0.0,
        soft_max=3.0,
        default=1.0,
        update=_setting_changed,
    )
    elastic: BoolProperty(
        name="Elastic",
        description="Relax the skin around the joints that muscles cross, so that it keeps its shape and volume there",
        update=_setting_changed,
    )
    iterations: IntProperty(
        name="Iterations",
        description="Rounds of relaxation in every frame: more is smoother and slower",
        min=1,
        max=100,
        soft_max=20,
        default=10,
        update=_setting_changed,
    )
    growth: PointerProperty(type=growth_settings.SinewGrowth, options={"HIDDEN"})
    baked_keys: CollectionProperty(type=SinewBakedKey, options={"HIDDEN"})
    bake_error_mm: FloatProperty(
        name="Bake Error",
        description="Largest distance between the live skin and the last bake, in mm; -1: never baked",
        default=-1.0,
        options={"HIDDEN"},
    )

    # armatures
    show_posed: BoolProperty(
        name="Muscles Follow the Pose",
        description="Show each tissue as it is in the current pose; off: in the shape of the rest pose",
        default=True,
        update=_setting_changed,
    )
    show_muscles: BoolProperty(
        name="Muscles", description="Show the muscles of this armature", default=True, update=_layers_changed
    )
    show_bones: BoolProperty(
        name="Bones", description="Show the tissues that stand for bones", default=True, update=_layers_changed
    )
    show_stuffing: BoolProperty(
        name="Stuffing", description="Show the stuffing: fat, organs, head, hands", default=True, update=_layers_changed
    )
    show_spheres: BoolProperty(
        name="Spheres", description="Show the spheres in the joints", default=True, update=_layers_changed
    )
    show_empties: BoolProperty(
        name="Empties",
        description="Show tissues as the Empties that can be selected and edited; off: only the shaded muscles, if they are on",
        default=True,
        update=_layers_changed,
    )
    show_shaded: BoolProperty(
        name="Shaded Muscles",
        description="Show all tissues as shaded ellipsoids: blue where shortened, white at rest, red where lengthened",
        options=set(),
        get=_show_shaded,
        set=_set_show_shaded,
    )
    shaded: PointerProperty(type=bpy.types.Object, options={"HIDDEN"})
    show_attachments: BoolProperty(
        name="Attachment Lines",
        description="Draw each muscle's tendons to its origin and insertion, wherever the viewport's overlays are on",
        default=False,
        update=_layers_changed,
    )
    mirror_x: BoolProperty(
        name="X Mirror",
        description=(
            "Moving, turning or scaling a tissue in the rest pose does the same to its twin on the other side. "
            "The armature's own X-Axis Mirror option does so, too"
        ),
        default=False,
    )
    active_tissue: IntProperty(
        name="Tissue",
        description="Click selects the tissue",
        options=set(),
        get=selection.active_row,
        set=selection.select_row,
    )


CLASSES = (SinewWrap, SinewBakedKey, growth_settings.SinewGrowth, SinewSettings)


def register():
    for cls in CLASSES:
        bpy.utils.register_class(cls)
    bpy.types.Object.sinew = PointerProperty(type=SinewSettings, name="Sinew", override={"LIBRARY_OVERRIDABLE"})


def unregister():
    del bpy.types.Object.sinew
    for cls in reversed(CLASSES):
        bpy.utils.unregister_class(cls)


def clear(carrier):
    """Takes every trace of the settings off an object."""
    carrier.property_unset("sinew")
    stored = carrier.bl_system_properties_get() if hasattr(carrier, "bl_system_properties_get") else carrier
    if stored is not None and "sinew" in stored:
        del stored["sinew"]
