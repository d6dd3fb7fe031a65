# SPDX-License-Identifier: GPL-3.0-or-later
"""The error that the add-on raises for problems that a user can fix."""


class SinewError(Exception):
    """The request can't be done. The text names the thing, its value and what to do.

    Operators and command-line verbs catch it once and report it. Code that looks at many objects, such as
    `live.frame` or `scene.characters`, catches it per object and keeps its text for the panels: no handler raises it.
    """
