# SPDX-License-Identifier: GPL-3.0-or-later
"""What can have changed since the last frame of all that a bind depends on."""

from enum import Flag


class EditScope(Flag):
    """Keys and drivers go on whatever this says.

    TRANSFORMS: scripts of others ran, which may move what Blender then does not list. ARMATURES: Blender lists an armature,
    as it does when bones are posed. ANY_DATA: something else was edited, or it is not known that nothing was.
    """

    NOTHING = 0
    TRANSFORMS = 1
    ARMATURES = 2
    ANY_DATA = 4
    ANYTHING = 7
