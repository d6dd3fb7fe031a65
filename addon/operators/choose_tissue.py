# SPDX-License-Identifier: GPL-3.0-or-later
"""`sinew.choose_tissue` selects the shaded muscle under the mouse, in the views X-ray and Muscles."""

import bpy
from bpy.types import Operator
from bpy_extras import view3d_utils

from ..display import shaded, visibility
from ..live import picking, session
from ..scene import characters, selection
from .base import Translated


class SINEW_OT_choose_tissue(Translated, Operator):
    """Select the shaded muscle under the mouse. A second click selects what Blender would select"""

    bl_idname, bl_label, bl_options = "sinew.choose_tissue", "Select Muscle under Mouse", {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context):
        if context.region_data is None or context.mode != "OBJECT":
            cls.poll_message_set("Point at a muscle in a 3D viewport, in Object Mode")
            return False
        if not _shown_rigs(context):
            cls.poll_message_set("No character shows its muscles. Set its view to X-ray or Muscles")
            return False
        return True

    def invoke(self, context, event):
        mouse = (event.mouse_region_x, event.mouse_region_y)
        start = view3d_utils.region_2d_to_origin_3d(context.region, context.region_data, mouse)
        along = view3d_utils.region_2d_to_vector_3d(context.region, context.region_data, mouse)
        found = tissue_at(context, start, along)
        if found is None or (found == context.object and found.select_get()):
            return {"PASS_THROUGH"}  # to the click's own meaning
        selection.select(found)
        return {"FINISHED"}


def tissue_at(context, start, along):
    """The Empty of the first shaded tissue on a ray in world space, or None. Another opaque object before it hides it.

    start: a point. along: a direction of any length.
    """
    nearest, found = float("inf"), None
    for rig in _shown_rigs(context):
        state = session.cached_rig(rig)
        tissues = characters.tissues_of(rig)
        kinds = visibility.shown_kinds(rig)
        is_shown = [tissues[index].sinew.tissue.kind in kinds for index in state.solved]
        hit = picking.first_hit(state, is_shown, rig.matrix_world, start, along)
        if hit is not None and hit.distance < nearest:
            nearest, found = hit.distance, tissues[state.solved[hit.tissue]]
    return None if found is None or _is_hidden(context, found.parent, start, along, nearest) else found


def _is_hidden(context, rig, start, along, distance: float) -> bool:
    """Whether an object that is not of a rig's character is before a distance on a ray."""
    is_hit, point, _normal, _face, before, _matrix = context.scene.ray_cast(
        context.evaluated_depsgraph_get(), start, along, distance=distance
    )
    if not is_hit or (point - start).length >= distance:
        return False
    return before.original not in (shaded.find(rig), *characters.skins_of(rig))


def _shown_rigs(context) -> list:
    """The visible rigs whose shaded muscles are shown."""
    rigs = (character.rig.find() for character in characters.in_file())
    return [rig for rig in rigs if rig and _is_shown(rig, context.view_layer)]


def _is_shown(rig, view_layer) -> bool:
    muscles = shaded.find(rig)
    state = session.cached_rig(rig) if muscles else None
    return state is not None and state.musculature is not None and muscles.visible_get(view_layer=view_layer)


KEYMAP = ("Object Mode", "EMPTY")
_registered: list = []


def register_keys():
    """Adds the click to the keymap of Object Mode. Without a window there is no keymap."""
    keys = bpy.context.window_manager.keyconfigs.addon
    if keys:
        keymap = keys.keymaps.new(name=KEYMAP[0], space_type=KEYMAP[1])
        item = keymap.keymap_items.new(SINEW_OT_choose_tissue.bl_idname, "LEFTMOUSE", "CLICK")
        _registered.append((keymap, item))


def unregister_keys():
    """Removes the click from the keymap."""
    for keymap, item in _registered:
        keymap.keymap_items.remove(item)
    _registered.clear()
