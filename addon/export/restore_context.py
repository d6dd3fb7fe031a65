# SPDX-License-Identifier: GPL-3.0-or-later
"""Work that needs another active object, selection, mode or frame than the person has, and gives all of it back."""

from contextlib import contextmanager

import bpy


@contextmanager
def undisturbed(context):
    """Object Mode with nothing selected while the context lasts; then active object, selection, mode and frame as before."""
    scene, layer = context.scene, context.view_layer
    active = layer.objects.active
    mode = active.mode if active else "OBJECT"
    frame = scene.frame_current, scene.frame_subframe
    selected = [found.name for found in layer.objects if found.select_get()]
    if mode != "OBJECT":
        bpy.ops.object.mode_set(mode="OBJECT")
    select(layer, [], None)
    try:
        yield
    finally:
        if layer.objects.active and layer.objects.active.mode != "OBJECT":
            bpy.ops.object.mode_set(mode="OBJECT")
        select(layer, [layer.objects.get(name) for name in selected], active)
        if mode != "OBJECT":
            bpy.ops.object.mode_set(mode=mode)
        if (scene.frame_current, scene.frame_subframe) != frame:
            scene.frame_set(frame[0], subframe=frame[1])


def select(layer, objects: list, active):
    """Selects these objects of a view layer alone, passing over those that are no more."""
    for found in layer.objects:
        found.select_set(False)
    for found in objects:
        if found is not None:
            found.select_set(True)
    layer.objects.active = active


def show(layer, collection, shown: bool):
    """Switches a collection on or off in a view layer; returns how it was."""
    found = _find(layer.layer_collection, collection)
    if found is None:
        return False
    before = not found.exclude
    found.exclude = not shown
    return before


def _find(above, collection):
    if above.collection == collection:
        return above
    return next((found for found in (_find(child, collection) for child in above.children) if found), None)
