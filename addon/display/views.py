# SPDX-License-Identifier: GPL-3.0-or-later
"""The three views of a character: its skin, its muscles under a translucent skin (X-ray), or its muscles alone.

Changing the view does not change the user's settings of a mesh: X-ray is a modifier, and Muscles hides meshes as H does, and
shows again only those that it hid. Saved files hold neither.
"""

import bpy

from ..scene import characters, stored_settings, tissue_collection
from . import shaded, translucent_skin

SKIN, XRAY, MUSCLES = "SKIN", "XRAY", "MUSCLES"


def of(rig) -> str:
    """The view of a rig. Does not create settings."""
    settings = stored_settings.rig_of(rig)
    return settings.view if settings is not None else SKIN


def apply(rig, view_layer):
    """Makes a rig's meshes and shaded muscles show its view, also meshes that joined the character since the last call."""
    view = of(rig)
    _show_muscles(rig, view != SKIN)
    meshes = characters.skins_of(rig)
    for mesh_object in meshes:
        if view == XRAY:
            translucent_skin.show(mesh_object)
        else:
            translucent_skin.remove(mesh_object)
    if view == MUSCLES:
        _hide(rig, meshes, view_layer)
    else:
        _show_hidden(rig, view_layer)


def rest(rig):
    """Shows the meshes of a rig as they are without Sinew, before the file is saved. `apply` shows the view again."""
    if of(rig) == XRAY:
        for mesh_object in characters.skins_of(rig):
            translucent_skin.rest(mesh_object)
    elif of(rig) == MUSCLES:
        _show_hidden(rig, bpy.context.view_layer)


def remove(rig):
    """Removes the view of a rig: its meshes are shown as they are without Sinew, and its shaded muscles are removed."""
    for mesh_object in characters.skins_of(rig):
        translucent_skin.remove(mesh_object)
    if stored_settings.rig_of(rig) is not None:
        _show_hidden(rig, bpy.context.view_layer)
    shaded.remove(rig)


def _show_muscles(rig, shown: bool):
    if shown == (shaded.find(rig) is not None):
        return
    if shown:
        shaded.create(rig, tissue_collection.collection_of(rig))
    else:
        shaded.remove(rig)
    characters.forget()


def _hide(rig, meshes: list, view_layer):
    hidden = rig.sinew.rig.hidden_by_view
    for mesh_object in meshes:
        if not mesh_object.hide_get(view_layer=view_layer) and view_layer.objects.get(mesh_object.name) == mesh_object:
            mesh_object.hide_set(True, view_layer=view_layer)
            hidden.add().name = mesh_object.name


def _show_hidden(rig, view_layer):
    hidden = rig.sinew.rig.hidden_by_view
    for entry in hidden:
        mesh_object = view_layer.objects.get(entry.name)
        if mesh_object:
            mesh_object.hide_set(False, view_layer=view_layer)
    if len(hidden):
        hidden.clear()
