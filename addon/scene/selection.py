# SPDX-License-Identifier: GPL-3.0-or-later
"""Selecting a tissue by its row in a list of all objects, as the panel's list does."""

import bpy

from . import tissue_empty


def active_row(_settings) -> int:
    """The place of the active tissue among all objects; -1 while something else is active."""
    active = bpy.context.view_layer.objects.active
    if active is None or not tissue_empty.is_tissue(active):
        return -1
    return bpy.data.objects.find(active.name)


def select_row(_settings, row: int):
    """Selects one tissue alone and makes it active, where the view layer has it."""
    if 0 <= row < len(bpy.data.objects):
        select(bpy.data.objects[row])


def select(empty):
    """Selects a tissue alone and makes it active; a hidden one becomes active without being selected."""
    view_layer = bpy.context.view_layer
    view_layer.update()  # what was linked or unlinked since may not be sorted in yet
    if view_layer.objects.get(empty.name) != empty or not tissue_empty.is_tissue(empty):
        return
    active = view_layer.objects.active
    if active and active.mode != "OBJECT":
        bpy.ops.object.mode_set(mode="OBJECT")
    for other in view_layer.objects.selected:
        other.select_set(False)
    empty.select_set(True)
    view_layer.objects.active = empty
