# SPDX-License-Identifier: GPL-3.0-or-later
"""What the user or a script may have edited since the last frame."""

from enum import Flag


class EditScope(Flag):
    """The kinds of data that may have been edited. Animated values are read in every frame, whatever these flags say.

    TRANSFORMS: handlers of other add-ons ran, which may have moved objects that Blender does not report.
    ARMATURES: Blender reports an armature, as it also does when bones are posed.
    ANY_DATA: other data was edited, or it is not known whether it was.
    """

    NOTHING = 0
    TRANSFORMS = 1
    ARMATURES = 2
    ANY_DATA = 4
    ANYTHING = 7
