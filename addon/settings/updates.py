# SPDX-License-Identifier: GPL-3.0-or-later
"""The consequences of a changed setting, as lists of listeners that higher folders fill.

The settings know nothing of what is kept between frames. `live/handlers` adds functions to the lists below; each is called
with the armature object that the change affects.
"""

from contextlib import contextmanager

from ..scene import armature_modifier, characters

# a shot can override the settings of a linked character
OVERRIDABLE = {"LIBRARY_OVERRIDABLE"}

on_rig_settings_changed: list = []  # of its tissues, its skins or the armature itself
on_bone_settings_changed: list = []
on_layers_changed: list = []  # other tissues of the armature are shown

on_enabled_changed: list = []  # of Sinew as a whole, called without an argument
on_preset_dropped: list = []  # an asset with a preset is in the scene, called without an argument

_is_silent = False
_is_enabled = True


def is_enabled() -> bool:
    """Whether Sinew deforms skins and shows muscles. The preferences can turn it off."""
    return _is_enabled


def set_enabled(enabled: bool):
    """Turns Sinew on or off, for all characters."""
    global _is_enabled
    if enabled != _is_enabled:
        _is_enabled = enabled
        for listener in on_enabled_changed:
            listener()


@contextmanager
def silent():
    """Suppresses update functions while stored values are moved."""
    global _is_silent
    before, _is_silent = _is_silent, True
    try:
        yield
    finally:
        _is_silent = before


def is_silent() -> bool:
    """Whether settings are being moved, so that no update function acts."""
    return _is_silent


def characters_changed(_settings, _context):
    """Update function of a setting that decides which objects belong to a character."""
    if not _is_silent:
        characters.forget()


def setting_changed(settings, _context):
    """Update function of a setting that the next frame reads.

    Blender reports the tagged object, except where a handler changed the setting, or where the object is disabled in
    viewports or in an excluded collection. So its armature is tagged as well.
    """
    if _is_silent:
        return
    changed = settings.id_data
    notify(on_rig_settings_changed, changed)
    changed.update_tag()
    if changed.parent:
        changed.parent.update_tag()


def bone_setting_changed(settings, context):
    """Update function of a setting of a pose bone."""
    if not _is_silent:
        notify(on_bone_settings_changed, settings.id_data)
        setting_changed(settings, context)


def notify(listeners: list, changed):
    """Calls the listeners for each armature that an object belongs to."""
    for rig in _rigs_of(changed):
        for listener in listeners:
            listener(rig)


def _rigs_of(changed) -> list:
    """The armature objects that an object is, is a child of, or is deformed by."""
    if changed.type == "ARMATURE":
        return [changed]
    rigs = [modifier.object for modifier in armature_modifier.armature_modifiers(changed)]
    if changed.parent and changed.parent.type == "ARMATURE":
        rigs.append(changed.parent)
    return list(dict.fromkeys(rigs))
