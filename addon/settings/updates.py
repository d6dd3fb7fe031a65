# SPDX-License-Identifier: GPL-3.0-or-later
"""What all of Sinew's settings share: what follows when one changes, and that a shot may set it for itself."""

from ..live import session
from ..scene import characters

# a character that is linked and overridden may be set otherwise than in the file that it is linked from
OVERRIDABLE = {"LIBRARY_OVERRIDABLE"}


def characters_changed(_settings, _context):
    """For a setting that says who belongs to whom."""
    characters.forget()


def setting_changed(settings, _context):
    """For a setting that the next frame reads: Blender then reports its object, unless it was changed by a handler.

    Of an object that is disabled in viewports Blender reports nothing: its rig stands for it.
    """
    session.mark_rigs_dirty()
    changed = settings.id_data
    changed.update_tag()
    if changed.hide_viewport and changed.parent:
        changed.parent.update_tag()
