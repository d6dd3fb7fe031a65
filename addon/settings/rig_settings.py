# SPDX-License-Identifier: GPL-3.0-or-later
"""`object.sinew.rig`: the settings of an armature with muscles."""

import bpy
from bpy.props import BoolProperty, IntProperty, PointerProperty
from bpy.types import PropertyGroup

from ..display import shaded, visibility
from ..scene import characters, selection, tissue_collection
from . import updates
from .updates import OVERRIDABLE, setting_changed


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


def _layer(name: str, description: str):
    return BoolProperty(
        name=name, description=description, default=True, update=_layers_changed, options=set(), override=OVERRIDABLE
    )


class SinewRigSettings(PropertyGroup):
    """The settings of an armature."""

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
        description="Show tissues as Empties, which can be selected and edited. Off: show only the shaded muscles",
        default=True,
        update=_layers_changed,
        override=OVERRIDABLE,
        options=set(),
    )
    show_shaded: BoolProperty(
        name="Shaded Muscles",
        description="Show all tissues as shaded ellipsoids: blue if shortened, white at rest, red if lengthened",
        options=set(),
        get=_show_shaded,
        set=_set_show_shaded,
    )
    shaded: PointerProperty(
        name="Shaded Object",
        description="The object that shows the shaded muscles",
        type=bpy.types.Object,
        options={"HIDDEN"},
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
            "Apply moving, rotating or scaling of a tissue in the rest pose to its mirror image as well. "
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


CLASSES = (SinewRigSettings,)
