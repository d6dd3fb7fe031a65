# SPDX-License-Identifier: GPL-3.0-or-later
"""Objects that long work looks up again in each step, because a user can rename or delete them in another window."""

import bpy

from ..errors import SinewError


def objects_named(names: list[str], again: str) -> list:
    """The objects with these names. Raises SinewError if one is missing. again: what to do then, as in "bake again"."""
    found = [bpy.data.objects.get(name) for name in names]
    missing = [name for name, existing in zip(names, found) if existing is None]
    if missing:
        raise SinewError(f"{', '.join(missing)} was renamed or deleted meanwhile: {again}")
    return found


def by_uid(uid: int):
    """The object with this session-wide identifier, whatever its name is now, or None if it was deleted."""
    return next((candidate for candidate in bpy.data.objects if candidate.session_uid == uid), None)
