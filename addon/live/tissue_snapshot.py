# SPDX-License-Identifier: GPL-3.0-or-later
"""Snapshots of all data that tissues depend on, to see whether a cached musculature still fits. Read in bulk, for speed."""

from operator import attrgetter

import bpy
import numpy as np

from ..scene import tissue_bones
from ..scene.animated_value import paths_of, values_of

# reading these from all objects of the file is faster than reading them from each tissue
_TRANSFORMS = (
    ("location", 3), ("rotation_euler", 3), ("rotation_quaternion", 4), ("rotation_axis_angle", 4), ("scale", 3),
    ("matrix_parent_inverse", 16), ("empty_display_size", 1),
)  # fmt: skip
_TENSION = "sinew.tissue.tension"
_WIDTH = sum(width for _name, width in _TRANSFORMS)


class ObjectTransforms:
    """The transforms of all objects of the file, read once. For one frame: it does not see later edits."""

    def __init__(self):
        self._read: np.ndarray | None = None

    def of(self, rows: np.ndarray) -> np.ndarray:
        """(rows, 34) float32: the transforms of the objects at these indices."""
        if self._read is None:
            count = len(bpy.data.objects)
            self._read, first = np.empty((count, _WIDTH), np.float32), 0
            for name, width in _TRANSFORMS:
                values = np.empty((count, width), np.float32)
                bpy.data.objects.foreach_get(name, values.reshape(-1))
                self._read[:, first : first + width] = values
                first += width
        return self._read[rows]


_OF_SETTINGS = attrgetter("origin_tendon", "insertion_tendon", "volume_keeping", "influence", "muted", "solo")
_OF_VIA = attrgetter("name", "parent_bone", "sinew.tissue.order")


def settings_of(empties: list, depsgraph) -> list[tuple]:
    """The settings of each tissue in an evaluation, without transforms. The name of the Empty comes first."""
    snapshots = []
    for empty in empties:
        values, tissue = values_of(empty, depsgraph), empty.sinew.tissue
        evaluated = tissue if values is empty else values.sinew.tissue
        settings = (empty.name, empty.parent_bone, tissue.kind, values.rotation_mode, *_OF_SETTINGS(evaluated))
        if tissue.kind == "MUSCLE":
            wraps = [wrap.sphere.name if wrap.sphere else "" for wrap in tissue.wraps]
            settings += (tissue_bones.insertion_bone_of(empty), *wraps)
        snapshots.append(settings)
    return snapshots


def via_settings_of(vias: list) -> list[tuple]:
    """The settings of each via point, without transforms. The name of the Empty comes first."""
    muscles = [via.sinew.tissue.muscle for via in vias]
    return [(*_OF_VIA(via), muscle.name_full if muscle else "") for via, muscle in zip(vias, muscles)]


def animated(empties: list) -> list[int]:
    """The indices, ascending, of the Empties that have keys or drivers."""
    return [index for index, empty in enumerate(empties) if empty.animation_data]


def with_animated_shape(empties: list) -> list[int]:
    """The indices, ascending, of the Empties that have keys or drivers for more than their tension."""
    return [index for index in animated(empties) if any(path != _TENSION for path in paths_of(empties[index]))]


def transforms_of(empties: list, rows: np.ndarray, depsgraph, read: ObjectTransforms) -> np.ndarray:
    """(Empties, 34) float32: all transforms in an evaluation that tissues depend on. rows: as from `rows_of`."""
    transforms = read.of(rows)
    for index in with_animated_shape(empties):
        transforms[index] = transform_of(empties[index], depsgraph)
    return transforms


def transform_of(empty, depsgraph) -> np.ndarray:
    """(34,) float32: the transforms of one Empty in an evaluation."""
    values = values_of(empty, depsgraph)
    numbers = (getattr(values, name) for name, _width in _TRANSFORMS)
    # foreach_get reads matrices column by column
    return np.concatenate([np.array(number, np.float32).T.reshape(-1) for number in numbers])


def rows_of(empties: list) -> np.ndarray:
    """The indices of Empties among all objects of the file."""
    row_of = {any_object.name_full: row for row, any_object in enumerate(bpy.data.objects)}
    return np.array([row_of[empty.name_full] for empty in empties], np.intp)
