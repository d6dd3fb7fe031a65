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

from ..display import shaded, timing_overlay, visibility
from ..live import session
from ..muscles import tissue_collection
from ..scene import characters, selection, tissue_bones, tissue_empty, tissue_size
from . import growth_settings
from .goal_settings import SinewGoal
from .skin_settings import SinewBakedKey, SkinSettings
from .updates import OVERRIDABLE, characters_changed, setting_changed

TISSUE_KINDS = (
    ("MUSCLE", "Muscle", "A belly between two tendons: it shortens, lengthens and bulges at constant volume"),
    ("BONE", "Bone", "Three ellipsoids along a bone: a shaft and two ends; rigid"),
    ("STUFFING", "Stuffing", "One rigid ellipsoid, for fat, organs, a head, a hand"),
    ("SPHERE", "Sphere", "A ball at a joint that never bulges"),
)
VIA_KIND = ("VIA", "Via Point", "A place on a bone that a muscle passes between its origin and its insertion")


def _show_shaded(settings) -> bool:
    return shaded.find(settings.id_data) is not None


def _set_show_shaded(settings, shown: bool):
    rig = settings.id_data
    if not shown:
        shaded.remove(rig)
    elif shaded.find(rig) is None:
        shaded.create(rig, tissue_collection.collection_of(rig))
    characters.forget()


def _layers_changed(settings, context):
    rig = settings.id_data
    visibility.apply(rig, [*characters.tissues_of(rig), *characters.vias_of(rig)], context.view_layer)
    session.forget_shown()  # what was hidden has not followed
    session.mark_rigs_dirty()  # of what is put away now, edits are not reported
    rig.update_tag()


def _layer(name: str, description: str):
    return BoolProperty(name=name, description=description, default=True, update=_layers_changed, override=OVERRIDABLE)


def _is_muscle(via, candidate) -> bool:
    return _is_neighbour(via, candidate, "MUSCLE")


def _is_sphere(wrap, candidate) -> bool:
    return _is_neighbour(wrap, candidate, "SPHERE")


def _is_neighbour(settings, candidate, kind: str) -> bool:
    is_tissue = tissue_empty.is_tissue(candidate) and candidate.sinew.kind == kind
    return is_tissue and candidate.parent == settings.id_data.parent


class SinewWrap(PropertyGroup):
    """A sphere that a muscle goes round; a pointer, so that it survives renaming, duplicating and appending."""

    sphere: PointerProperty(
        name="Sphere",
        description="The joint sphere that the muscle goes round",
        type=bpy.types.Object,
        poll=_is_sphere,
        update=setting_changed,
        override=OVERRIDABLE,
    )


class SinewSettings(SkinSettings, PropertyGroup):
    """Sinew's settings of one object; which of them count depends on its type."""

    # tissues (Empties)
    kind: EnumProperty(
        name="Kind",
        description="What the Empty stands for",
        items=(("NONE", "None", "Not a tissue"), *TISSUE_KINDS, VIA_KIND),
        default="NONE",
        update=characters_changed,
        override=OVERRIDABLE,
    )
    origin_bone: StringProperty(
        name="Origin Bone",
        description="The bone that carries the tissue; a muscle's origin lies on it",
        get=tissue_bones.origin_bone,
        set=tissue_bones.set_origin_bone,
        update=setting_changed,
    )
    insertion_bone: StringProperty(
        name="Insertion Bone",
        description="The bone that the muscle pulls; its insertion lies on it",
        get=tissue_bones.insertion_bone,
        set=tissue_bones.set_insertion_bone,
        update=setting_changed,
    )
    origin_tendon: FloatProperty(
        name="Origin Tendon",
        description="Length of the tendon between origin and belly; it keeps this length in every pose",
        subtype="DISTANCE",
        min=0.0,
        soft_max=0.5,
        update=setting_changed,
        override=OVERRIDABLE,
    )
    insertion_tendon: FloatProperty(
        name="Insertion Tendon",
        description="Length of the tendon between belly and insertion; it keeps this length in every pose",
        subtype="DISTANCE",
        min=0.0,
        soft_max=0.5,
        update=setting_changed,
        override=OVERRIDABLE,
    )
    volume_keeping: FloatProperty(
        name="Volume Keeping",
        description="How much a belly widens as it shortens: 1 keeps its volume exactly, 0 keeps its widths",
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
            "Tenses the muscle at unchanged length: the belly draws together and thickens. Can be keyed or driven; "
            "keys also act while the muscle is disabled in viewports, drivers then rest"
        ),
        min=0.0,
        max=1.0,
        subtype="FACTOR",
        update=setting_changed,
        override=OVERRIDABLE,
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
        get=tissue_size.semi_axes,
        set=tissue_size.set_semi_axes,
        update=setting_changed,
    )
    width_ratio: FloatProperty(
        name="Width Ratio",
        description="The belly's width along its local X over that along Y; its cross-section keeps its area",
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
        description="Distance of the belly's centre from the line of its origin bone, in the rest pose",
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
        description="How much thicker than elsewhere a grown skin is over this tissue; counts when the skin is grown again",
        subtype="DISTANCE",
        min=0.0,
        soft_max=0.1,
        precision=4,
        override=OVERRIDABLE,
    )
    wraps: CollectionProperty(
        name="Wraps",
        description="The spheres that the muscle goes round",
        type=SinewWrap,
        override={*OVERRIDABLE, "USE_INSERTION"},
    )

    # via points (Empties)
    muscle: PointerProperty(
        name="Muscle",
        description="The muscle that passes here",
        type=bpy.types.Object,
        poll=_is_muscle,
        update=characters_changed,
        override=OVERRIDABLE,
    )
    order: IntProperty(
        name="Order",
        description="Where along the muscle: it passes its via points in rising order",
        update=setting_changed,
        override=OVERRIDABLE,
    )

    quality_text: PointerProperty(type=bpy.types.Text, options={"HIDDEN"})
    quality_json: PointerProperty(type=bpy.types.Text, options={"HIDDEN"})
    quality_summary: StringProperty(options={"HIDDEN"})
    growth: PointerProperty(type=growth_settings.SinewGrowth, options={"HIDDEN"}, override=OVERRIDABLE)

    is_put_away: BoolProperty(options={"HIDDEN"}, override=OVERRIDABLE)  # see layers.visibility

    # goals (Empties)
    goal: PointerProperty(type=SinewGoal, name="Goal", override=OVERRIDABLE)

    # armatures
    show_posed: BoolProperty(
        name="Muscles Follow the Pose",
        description="Show each tissue as it is in the current pose; off: in the shape of the rest pose",
        default=True,
        update=setting_changed,
        override=OVERRIDABLE,
    )
    show_muscles: _layer("Muscles", "Show the muscles of this armature")
    show_bones: _layer("Bones", "Show the tissues that stand for bones")
    show_stuffing: _layer("Stuffing", "Show the stuffing: fat, organs, head, hands")
    show_spheres: _layer("Spheres", "Show the spheres in the joints")
    show_empties: BoolProperty(
        name="Empties",
        description="Show tissues as the Empties that can be selected and edited; off: only the shaded muscles, if they are on",
        default=True,
        update=_layers_changed,
        override=OVERRIDABLE,
    )
    show_shaded: BoolProperty(
        name="Shaded Muscles",
        description="Show all tissues as shaded ellipsoids: blue where shortened, white at rest, red where lengthened",
        options=set(),
        get=_show_shaded,
        set=_set_show_shaded,
    )
    shaded: PointerProperty(type=bpy.types.Object, options={"HIDDEN"})
    export_copy: PointerProperty(type=bpy.types.Collection, options={"HIDDEN"})
    show_attachments: BoolProperty(
        name="Attachment Lines",
        description="Draw each muscle's tendons to its origin and insertion, wherever the viewport's overlays are on",
        default=False,
        update=_layers_changed,
        override=OVERRIDABLE,
    )
    mirror_x: BoolProperty(
        name="X Mirror",
        description=(
            "Moving, turning or scaling a tissue in the rest pose does the same to its twin on the other side. "
            "The armature's own X-Axis Mirror option does so, too"
        ),
        default=False,
        override=OVERRIDABLE,
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
    bpy.types.Object.sinew = PointerProperty(type=SinewSettings, name="Sinew", override=OVERRIDABLE)
    bpy.types.WindowManager.sinew_show_times = BoolProperty(
        name="Show Times",
        description="Show over the viewport how long a frame takes: pose, muscles, skin, total; and frames per second",
        options=set(),
        get=lambda _manager: timing_overlay.is_shown(),
        set=lambda _manager, shown: timing_overlay.show(shown),
    )


def unregister():
    del bpy.types.WindowManager.sinew_show_times
    del bpy.types.Object.sinew
    for cls in reversed(CLASSES):
        bpy.utils.unregister_class(cls)


def clear(carrier):
    """Takes every trace of the settings off an object or a pose bone."""
    carrier.property_unset("sinew")
    stored = carrier.bl_system_properties_get() if hasattr(carrier, "bl_system_properties_get") else carrier
    if stored is not None and "sinew" in stored:
        del stored["sinew"]
