# SPDX-License-Identifier: GPL-3.0-or-later
"""Shows tissues in the current pose, by delta transforms of their Empties, which leave the user's transforms alone."""

import bpy
import _sinew
import numpy as np
from mathutils import Euler, Matrix, Quaternion, Vector

from . import bone_geometry, rig_pose
from .tissue_empty import rest_transform

_EULER = "delta_rotation_euler"
_QUATERNION = "delta_rotation_quaternion"
# Blender has no delta transform for the rotation mode Axis Angle
_ROTATION_OF_MODE = {"QUATERNION": _QUATERNION, "AXIS_ANGLE": ""}
# the columns of `_sinew.ShownTissues.deltas`
_COLUMNS = {"delta_location": slice(0, 3), _QUATERNION: slice(3, 7), _EULER: slice(7, 10), "delta_scale": slice(10, 13)}
_COLUMN_COUNT = 13
# a changed delta transform requires only the object's transform to be evaluated
_TAG = {"OBJECT"}


class DeltaWrites:
    """The delta transforms that a frame writes, of all characters: each property is read and written once."""

    def __init__(self):
        self._rows: list[np.ndarray] = []
        self._deltas: list[np.ndarray] = []
        self._rotations: list[str] = []
        self._empties: list = []

    def add(self, empties: list, rows: np.ndarray, deltas: np.ndarray, rotations: list[str]):
        """Adds Empties. rows: their indices among all objects of the file. rotations: the property of each rotation."""
        self._empties += empties
        self._rows.append(rows)
        self._deltas.append(deltas)
        self._rotations += rotations

    def flush(self):
        """Writes what was added."""
        if not self._empties:
            return
        rows, deltas, rotations = np.concatenate(self._rows), np.concatenate(self._deltas), np.array(self._rotations)
        for name, columns in _COLUMNS.items():
            has = rotations == name if "rotation" in name else np.ones(len(rows), bool)
            if has.any():
                _write_in_bulk(name, rows[has], deltas[has, columns])
        for empty in self._empties:
            empty.update_tag(refresh=_TAG)


class TissueDisplay:
    """The Empties of a rig's tissues, and the delta transforms that they show."""

    def __init__(self, rig, rest: rig_pose.RigRest, empties: list):
        transforms = [rest_transform(empty) for empty in empties]
        modes = [empty.rotation_mode for empty in empties]
        to_bones = [
            Matrix.Translation((0.0, bone_geometry.bone_length(rig, empty.parent_bone), 0.0)) @ empty.matrix_parent_inverse
            for empty in empties
        ]
        self._kinds = [empty.sinew.tissue.kind for empty in empties]
        self._rotations = [_ROTATION_OF_MODE.get(mode, _EULER) for mode in modes]
        self._shown = _sinew.ShownTissues(
            rest.skeleton,
            [empty.name for empty in empties],
            np.array([rest.index_of_bone[empty.parent_bone] for empty in empties], np.int32),
            _stacked([matrix.transposed() for matrix in to_bones], (4, 4)),
            _stacked([location for location, _rotation, _scale in transforms], (3,)),
            _stacked([rotation for _location, rotation, _scale in transforms], (4,)),
            _stacked([scale * empty.empty_display_size for (*_, scale), empty in zip(transforms, empties)], (3,)),
            ["XYZ" if mode in _ROTATION_OF_MODE else mode for mode in modes],
        )
        # foreach_set silently skips linked objects
        self._is_linked = [bool(empty.library or empty.override_library) for empty in empties]
        self._deltas = np.empty((len(empties), _COLUMN_COUNT), np.float32)
        self._written = np.full_like(self._deltas, np.nan)

    def forget(self):
        """Makes the next `show` write all delta transforms, because something else may have changed them."""
        self._written[:] = np.nan

    def show(
        self,
        empties: list,
        rows: np.ndarray,
        kinds: frozenset[str],
        pose: np.ndarray,
        posed: np.ndarray,
        writes: DeltaWrites,
    ):
        """Makes the Empties of some kinds show their tissues. Empties that are disabled in viewports are left out.

        rows: the indices of the Empties among all objects of the file. pose, posed: as in the core's `Musculature.pose`.
        writes: takes what is to be written. Only linked Empties and overrides are written at once.
        """
        self._shown.deltas(pose, posed, self._deltas)
        # an Empty follows its origin bone, so only a tissue that changed relative to that bone needs a write
        changed = (self._deltas != self._written).any(axis=1)
        dirty = [
            index
            for index in np.flatnonzero(changed).tolist()
            if self._kinds[index] in kinds and not empties[index].hide_viewport
        ]
        if not dirty:
            return
        self._written[dirty] = self._deltas[dirty]
        for index in dirty:
            if self._is_linked[index]:
                self._write_one(empties[index], index)
        local = [index for index in dirty if not self._is_linked[index]]
        rotations = [self._rotations[index] for index in local]
        writes.add([empties[index] for index in local], rows[local], self._deltas[local], rotations)

    def _write_one(self, empty, index: int):
        for name in ("delta_location", "delta_scale", self._rotations[index]):
            if name:
                setattr(empty, name, self._deltas[index, _COLUMNS[name]].tolist())


def _stacked(values: list, shape: tuple) -> np.ndarray:
    return np.array(values, np.float32).reshape(-1, *shape)


def _write_in_bulk(name: str, rows: np.ndarray, values: np.ndarray):
    """Sets a property of the objects in these rows. All other objects of the file keep theirs.

    Setting the property of one object at a time is slower, because Blender tags the object each time.
    """
    objects = bpy.data.objects
    of_all = np.empty((len(objects), values.shape[1]), np.float32)
    objects.foreach_get(name, of_all.reshape(-1))
    of_all[rows] = values
    objects.foreach_set(name, of_all.reshape(-1))


def show_rest(empty):
    """Resets the delta transforms. The Empty then shows the ellipsoid of the rest pose, moved by its origin bone."""
    for name, identity in (
        ("delta_location", Vector()),
        ("delta_scale", Vector((1.0, 1.0, 1.0))),
        (_QUATERNION, Quaternion()),
        (_EULER, Euler()),
    ):
        if getattr(empty, name) != identity:
            setattr(empty, name, identity)
