# SPDX-License-Identifier: GPL-3.0-or-later
"""`object.sinew.rig`: the settings of an armature with muscles."""

import bpy
from bpy.props import BoolProperty, CollectionProperty, EnumProperty, IntProperty, PointerProperty, StringProperty
from bpy.types import PropertyGroup

from ..display import shaded, views, visibility
from ..scene import characters, selection, tissue_collection
from . import group_settings, updates
from .updates import OVERRIDABLE, setting_changed

VIEWS = (
    (views.SKIN, "Skin", "Show the skin as it is rendered"),
    (views.XRAY, "X-ray", "Show the muscles under a translucent skin"),
    (views.MUSCLES, "Muscles", "Show the muscles alone. The meshes of the character are hidden"),
)
COLOURS = (
    ("ANATOMY", "Anatomy", "Red bellies, pale tendons, ivory bones. The chosen tissue is orange"),
    ("STRETCH", "Stretch", "Blue: shortened to 60 % of the rest length and less. White: as at rest. Red: 140 % and more"),
)


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
    if updates.is_silent():
        return
    rig = settings.id_data
    visibility.apply(rig, [*characters.tissues_of(rig), *characters.vias_of(rig)], context.view_layer)
    updates.notify(updates.on_layers_changed, rig)
    rig.update_tag()


def _view_changed(settings, context):
    if updates.is_silent():
        return
    rig = settings.id_data
    views.apply(rig, context.view_layer)
    updates.notify(updates.on_layers_changed, rig)
    rig.update_tag()


def _colours_changed(settings, _context):
    if not updates.is_silent():
        settings.id_data.update_tag()


def _layer(name: str, description: str):
    return BoolProperty(
        name=name, description=description, default=True, update=_layers_changed, options=set(), override=OVERRIDABLE
    )


class SinewHiddenMesh(PropertyGroup):
    """A mesh that the view Muscles hid."""

    # a pointer would keep a mesh in the file that the user deletes
    name: StringProperty(name="Mesh", description="Name of the mesh that the view Muscles hid", options={"HIDDEN"})


class SinewRigSettings(PropertyGroup):
    """The settings of an armature."""

    view: EnumProperty(
        name="View",
        description="What the viewport shows of this character. Renders are not affected",
        items=VIEWS,
        default=views.SKIN,
        options=set(),
        update=_view_changed,
        override=OVERRIDABLE,
    )
    colours: EnumProperty(
        name="Colors",
        description="What the colors of the shaded muscles mean",
        items=COLOURS,
        default="ANATOMY",
        options=set(),
        update=_colours_changed,
        override=OVERRIDABLE,
    )
    chosen: StringProperty(
        name="Chosen Tissue",
        description=(
            "Name of the tissue that was chosen last, in the list or by a click. Its Empty is shown even if Empties are off"
        ),
        update=_layers_changed,
        options={"HIDDEN"},
    )
    groups: CollectionProperty(
        name="Groups",
        description="The groups of tissues that can be changed together",
        type=group_settings.SinewMuscleGroup,
        override={*OVERRIDABLE, "USE_INSERTION"},
    )
    hidden_by_view: CollectionProperty(
        name="Hidden Meshes",
        description="The meshes that the view Muscles hid",
        type=SinewHiddenMesh,
        options={"HIDDEN"},
        override={*OVERRIDABLE, "USE_INSERTION"},
    )

    show_posed: BoolProperty(
        name="Muscles Follow the Pose",
        description="Show each tissue in the current pose. Off: in the shape of the rest pose",
        default=True,
        update=setting_changed,
        override=OVERRIDABLE,
        options=set(),
    )
    show_muscles: _layer("Muscles", "Show the muscles of this armature")
    show_bones: _layer("Bones", "Show the tissues that represent bones")
    show_stuffing: _layer("Stuffing", "Show the stuffing: fat, organs, head and hands")
    show_spheres: _layer("Spheres", "Show the spheres in the joints")
    show_empties: BoolProperty(
        name="Empties",
        description=(
            "Show all tissues as Empties, which can be selected and edited. Off: show only the Empty of the chosen tissue"
        ),
        default=True,
        update=_layers_changed,
        override=OVERRIDABLE,
        options=set(),
    )
    show_shaded: BoolProperty(
        name="Shaded Muscles",
        description="Show all tissues as shaded ellipsoids in the current pose, with their tendons",
        options=set(),
        get=_show_shaded,
        set=_set_show_shaded,
    )
    shaded: PointerProperty(
        name="Shaded Object",
        description="The object that shows the shaded muscles",
        type=bpy.types.Object,
        options={"HIDDEN"},
        override=OVERRIDABLE,
    )
    export_copy: PointerProperty(
        name="Export Copy",
        description="The collection with the copy of this armature for export",
        type=bpy.types.Collection,
        options={"HIDDEN"},
    )
    show_attachments: BoolProperty(
        name="Attachment Lines",
        description="Draw the tendons of each muscle to its origin and insertion, in viewports with overlays",
        default=False,
        update=_layers_changed,
        override=OVERRIDABLE,
        options=set(),
    )
    mirror_x: BoolProperty(
        name="X Mirror",
        description=(
            "Apply moving, rotating or scaling of a tissue in the rest pose, and its handles in any pose, "
            "to its mirror image as well. "
            "The armature's X-Axis Mirror option does the same"
        ),
        default=False,
        override=OVERRIDABLE,
        options=set(),
    )
    active_tissue: IntProperty(
        name="Tissue",
        description="Click to select the tissue",
        options=set(),
        get=selection.active_row,
        set=selection.select_row,
    )


CLASSES = (*group_settings.CLASSES, SinewHiddenMesh, SinewRigSettings)
