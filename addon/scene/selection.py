# SPDX-License-Identifier: GPL-3.0-or-later
"""Selects tissues by their row in the list of the panel, which lists all objects of the file."""

import bpy

from . import tissue_empty


def active_row(_settings) -> int:
    """The index of the active tissue among all objects, or -1 if the active object is not a tissue."""
    active = bpy.context.view_layer.objects.active
    if active is None or not tissue_empty.is_tissue(active):
        return -1
    return bpy.data.objects.find(active.name)


def select_row(_settings, row: int):
    """Makes the tissue in a row the only selected object and the active one, if it is in the view layer."""
    if 0 <= row < len(bpy.data.objects):
        select(bpy.data.objects[row])


def select(empty):
    """Makes a tissue the only selected object, the active one, and the chosen tissue of its rig, whose Empty is shown.

    A tissue whose layer is off becomes active but is not selected.
    """
    view_layer = bpy.context.view_layer
    view_layer.update()  # objects that were just linked or unlinked may still be missing or present
    if view_layer.objects.get(empty.name) != empty or not tissue_empty.is_tissue(empty):
        return
    active = view_layer.objects.active
    if active and active.mode != "OBJECT":
        bpy.ops.object.mode_set(mode="OBJECT")
    for selected in view_layer.objects.selected:
        selected.select_set(False)
    choose(empty)
    empty.select_set(True)
    view_layer.objects.active = empty


def choose(empty):
    """Makes a tissue the chosen one of its rig: its Empty is shown, also if Empties are off."""
    rig = empty.parent
    if rig and rig.type == "ARMATURE" and not rig.library and rig.sinew.rig.chosen != empty.name:
        rig.sinew.rig.chosen = empty.name


def make_active(found):
    """Makes an object the only selected object and the active one."""
    view_layer = bpy.context.view_layer
    for selected in view_layer.objects.selected:
        selected.select_set(False)
    found.select_set(True)
    view_layer.objects.active = found
