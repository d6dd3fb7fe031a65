# SPDX-License-Identifier: GPL-3.0-or-later
"""What can have changed since the last frame of all that a bind depends on, poses left aside."""

from enum import IntEnum


class Edited(IntEnum):
    """From least to most.

    NOTHING: only keys and drivers went on. TRANSFORMS: scripts of others ran, too, which may move what Blender then does
    not list. ANYTHING: something was edited, or it is not known that nothing was.
    """

    NOTHING = 0
    TRANSFORMS = 1
    ANYTHING = 2
