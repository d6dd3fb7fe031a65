# SPDX-License-Identifier: GPL-3.0-or-later
"""The Live switch: either the live correction deforms a mesh, or its baked shape keys and point cache do."""

import bpy

from . import correction_modifier, stored_settings

CACHE_MODIFIER = "Sinew Cache"


def cache_modifier_of(skin):
    """The Mesh Cache modifier that plays Sinew's point cache, or None. It may have been renamed or moved.

    On a library override, Blender creates added modifiers again when it loads the file, with new identifiers. There the
    name identifies the modifier.
    """
    settings = stored_settings.skin_of(skin)
    uid = settings.cache_modifier if settings is not None else 0
    caches = [modifier for modifier in skin.modifiers if uid and modifier.type == "MESH_CACHE"]
    by_uid = [modifier for modifier in caches if modifier.persistent_uid == uid]
    by_name = [modifier for modifier in caches if modifier.name == CACHE_MODIFIER]
    return next(iter(by_uid or by_name), None)


def show_live(skin):
    """Turns on the live correction, or the baked shape keys and point cache, according to the setting Live of `skin`."""
    live = skin.sinew.skin.live
    for modifier, shown in ((correction_modifier.modifier_of(skin), live), (cache_modifier_of(skin), not live)):
        if modifier:
            modifier.show_viewport = shown
            modifier.show_render = shown
    skin.sinew.skin.is_correction_hidden = False
    keys = skin.data.shape_keys if skin.type == "MESH" else None
    if keys:
        for baked in skin.sinew.skin.baked_keys:
            key = keys.key_blocks.get(baked.name)
            if key:
                key.mute = live or baked.muted_by_sinew


def switches_of(skins: list) -> dict[int, bool]:
    """The switch Live of each skin, by its session-wide identifier, for `restore_switches`."""
    return {skin.session_uid: skin.sinew.skin.live for skin in skins}


def restore_switches(switches: dict[int, bool]):
    """Sets the switch Live of each skin that still exists. It may have been renamed."""
    for candidate in bpy.data.objects:
        live = switches.get(candidate.session_uid)
        if live is not None and candidate.sinew.skin.live != live:
            candidate.sinew.skin.live = live


def hide_correction(skin):
    """Hides the correction of a mesh object whose mesh holds the correction of another object, until `show_live`."""
    modifier = correction_modifier.modifier_of(skin)
    if modifier and (modifier.show_viewport or modifier.show_render):
        modifier.show_viewport = modifier.show_render = False
        skin.sinew.skin.is_correction_hidden = True
