# SPDX-License-Identifier: GPL-3.0-or-later
"""Work that needs another active object, selection, mode or frame than the user has, and restores all of them."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager

import bpy

from ..scene.current_frame import visit_frames


@contextmanager
def restored_context(context) -> Iterator[Callable[[float], None]]:
    """Switches to Object Mode with nothing selected. Restores active object, selection, mode and frame when the block ends.

    Yields a function that makes a frame current; see `visit_frames`.
    """
    scene, layer = context.scene, context.view_layer
    active = layer.objects.active
    mode = active.mode if active else "OBJECT"
    active_uid = active.session_uid if active else 0
    selected = [each.session_uid for each in layer.objects if each.select_get()]
    with visit_frames(scene) as go_to:
        if mode != "OBJECT":
            bpy.ops.object.mode_set(mode="OBJECT")
        select(layer, [], None)
        try:
            yield go_to
        finally:
            if layer.objects.active and layer.objects.active.mode != "OBJECT":
                bpy.ops.object.mode_set(mode="OBJECT")
            # objects may have been renamed or deleted meanwhile
            existing = {each.session_uid: each for each in layer.objects}
            select(layer, [existing.get(uid) for uid in selected], existing.get(active_uid))
            if mode != "OBJECT" and layer.objects.active:
                bpy.ops.object.mode_set(mode=mode)


def select(layer, objects: list, active):
    """Selects only these objects of a view layer. None represents an object that no longer exists."""
    for each in layer.objects:
        each.select_set(False)
    for each in objects:
        if each is not None:
            each.select_set(True)
    layer.objects.active = active


def show(layer, collection, shown: bool) -> bool:
    """Includes a collection in a view layer or excludes it. Returns whether it was included before."""
    layer_collection = _find(layer.layer_collection, collection)
    if layer_collection is None:
        return False
    before = not layer_collection.exclude
    layer_collection.exclude = not shown
    return before


def _find(parent, collection):
    """Searches the layer collections below `parent` for the one that shows a collection."""
    if parent.collection == collection:
        return parent
    return next((each for each in (_find(child, collection) for child in parent.children) if each), None)
