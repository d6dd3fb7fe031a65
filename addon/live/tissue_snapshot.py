# SPDX-License-Identifier: GPL-3.0-or-later
"""All that tissues depend on, read to see whether a kept musculature still fits; as fast as Blender lets a script read it."""

from operator import attrgetter

import bpy
import numpy as np

from ..scene import tissue_bones

# read in bulk from all objects of the file, which takes less time than from each of ours
_TRANSFORMS = (
    ("location", 3), ("rotation_euler", 3), ("rotation_quaternion", 4), ("scale", 3), ("matrix_parent_inverse", 16),
    ("empty_display_size", 1),
)  # fmt: skip
_WIDTH = sum(width for _name, width in _TRANSFORMS)
_OF_EMPTY = attrgetter("name", "rotation_mode", "parent_bone")
_OF_SETTINGS = attrgetter("kind", "origin_tendon", "insertion_tendon", "volume_keeping")
_OF_VIA = attrgetter("name", "parent_bone", "sinew.order")


def settings_of(empties: list) -> list[tuple]:
    """What of each Empty's settings its tissue depends on, its name first."""
    found = []
    for empty in empties:
        own = empty.sinew
        settings = _OF_SETTINGS(own)
        if settings[0] == "MUSCLE":
            wraps = [wrap.sphere.name if wrap.sphere else "" for wrap in own.wraps]
            settings += (tissue_bones.insertion_bone_of(empty), *wraps)
        found.append(_OF_EMPTY(empty) + settings)
    return found


def via_settings_of(vias: list) -> list[tuple]:
    """What of the Empties of via points, other than their transforms, their muscles depend on, the name first."""
    muscles = [via.sinew.muscle for via in vias]
    return [(*_OF_VIA(via), muscle.name_full if muscle else "") for via, muscle in zip(vias, muscles)]


def animated(empties: list) -> list[int]:
    """The places of those that have keys or drivers, rising."""
    return [place for place, empty in enumerate(empties) if empty.animation_data]


def transforms_of(rows: np.ndarray) -> np.ndarray:
    """(Empties, 30) float32: all transforms that tissues depend on.

    rows: the places of the Empties among all objects of the file.
    """
    count = len(bpy.data.objects)
    found, first = np.empty((len(rows), _WIDTH), np.float32), 0
    for name, width in _TRANSFORMS:
        values = np.empty((count, width), np.float32)
        bpy.data.objects.foreach_get(name, values.reshape(-1))
        found[:, first : first + width] = values[rows]
        first += width
    return found


def rows_of(empties: list) -> np.ndarray:
    """The places of objects among all objects of the file."""
    places = {found.name_full: row for row, found in enumerate(bpy.data.objects)}
    return np.array([places[empty.name_full] for empty in empties], np.intp)
