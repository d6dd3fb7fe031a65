# SPDX-License-Identifier: GPL-3.0-or-later
"""Data that is linked from another file, which Blender does not let anyone change."""

from ..errors import SinewError


def writable(rig):
    """Returns the rig if its tissues can be changed. Raises SinewError if it is linked from another file."""
    if rig.library:
        raise SinewError(f"{rig.name} is linked from another file: make a library override of it first")
    return rig
