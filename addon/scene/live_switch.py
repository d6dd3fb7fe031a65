# SPDX-License-Identifier: GPL-3.0-or-later
"""The only reader and writer of skin meshes: rest points, edges and weights in, the correction out. (What a person paints
for Sinew on them is for `painted_io`.)

The correction is a vector attribute that a Geometry Nodes modifier, first in the stack, adds to the points before the
Armature modifier. Nothing else of the mesh is touched.
"""

from . import correction_modifier

CACHE_MODIFIER = "Sinew Cache"


def cache_modifier_of(skin):
    """The Mesh Cache modifier that plays what Sinew baked into a file, however it was renamed or moved; or None.

    On a library override, Blender makes added modifiers anew as it loads, with other identifiers: there the name counts.
    """
    uid = skin.sinew.cache_modifier
    caches = [modifier for modifier in skin.modifiers if uid and modifier.type == "MESH_CACHE"]
    same = [modifier for modifier in caches if modifier.persistent_uid == uid]
    named = [modifier for modifier in caches if modifier.name == CACHE_MODIFIER]
    return next(iter(same or named), None)


def show_live(skin):
    """Lets either the live correction or what was baked (shape keys, a point cache) act, never both, as
    `skin.sinew.live` says."""
    live = skin.sinew.live
    for modifier, shown in ((correction_modifier.modifier_of(skin), live), (cache_modifier_of(skin), not live)):
        if modifier:
            modifier.show_viewport = shown
            modifier.show_render = shown
    keys = skin.data.shape_keys if skin.type == "MESH" else None
    if keys:
        for baked in skin.sinew.baked_keys:
            key = keys.key_blocks.get(baked.name)
            if key:
                key.mute = live or baked.silenced
