# SPDX-License-Identifier: GPL-3.0-or-later
"""What all of Sinew's settings share: what follows when one changes, and that a shot may set it for itself."""

from . import roster, session

# a character that is linked and overridden may be set otherwise than in the file that it is linked from
OVERRIDABLE = {"LIBRARY_OVERRIDABLE"}


def roster_changed(_settings, _context):
    """For a setting that says who belongs to whom."""
    roster.forget()


def setting_changed(settings, _context):
    """For a setting that the next frame reads: Blender then reports its object, unless it was changed by a handler.

    Of an object that is disabled in viewports Blender reports nothing: its rig stands for it.
    """
    session.suspect_rigs()
    changed = settings.id_data
    changed.update_tag()
    if changed.hide_viewport and changed.parent:
        changed.parent.update_tag()
