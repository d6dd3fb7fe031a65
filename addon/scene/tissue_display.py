# SPDX-License-Identifier: GPL-3.0-or-later
"""How Empties show their tissues in a pose: through delta transforms, which leave alone what the person set."""

import bpy
import _sinew
import numpy as np
from mathutils import Euler, Matrix, Quaternion, Vector

from . import bone_geometry, rig_pose
from .tissue_empty import rest_transform

# Blender gives scripts no delta for an axis and angle
_ROTATION_OF_MODE = {"QUATERNION": "delta_rotation_quaternion", "AXIS_ANGLE": ""}
_ANGLES = "delta_rotation_euler"
# the columns of what the core gives
_COLUMNS = {
    "delta_location": slice(0, 3), "delta_rotation_quaternion": slice(3, 7), _ANGLES: slice(7, 10), "delta_scale": slice(10, 13)
}  # fmt: skip
_WIDTH = 13
# what of an Empty its delta transforms make Blender evaluate
_TAG = {"OBJECT"}


class TissueDisplay:
    """The Empties of a rig's solved tissues, and what they show."""

    def __init__(self, rig, rest: rig_pose.RigRest, empties: list):
        own = [rest_transform(empty) for empty in empties]
        modes = [empty.rotation_mode for empty in empties]
        to_bones = [
            Matrix.Translation((0.0, bone_geometry.bone_length(rig, empty.parent_bone), 0.0)) @ empty.matrix_parent_inverse
            for empty in empties
        ]
        self._kinds = [empty.sinew.kind for empty in empties]
        self._rotations = [_ROTATION_OF_MODE.get(mode, _ANGLES) for mode in modes]
        self._shown = _sinew.ShownTissues(
            rest.skeleton,
            [empty.name for empty in empties],
            np.array([rest.frame_of_bone[empty.parent_bone] for empty in empties], np.int32),
            _stacked([matrix.transposed() for matrix in to_bones], (4, 4)),
            _stacked([location for location, _rotation, _scale in own], (3,)),
            _stacked([rotation for _location, rotation, _scale in own], (4,)),
            _stacked([scale * empty.empty_display_size for (*_, scale), empty in zip(own, empties)], (3,)),
            ["XYZ" if mode in _ROTATION_OF_MODE else mode for mode in modes],
        )
        self._deltas = np.empty((len(empties), _WIDTH), np.float32)
        self._last = np.full_like(self._deltas, np.nan)

    def forget(self):
        """Nothing of what the Empties show can be relied on any more: the next time all of them show their tissue."""
        self._last[:] = np.nan

    def show(self, empties: list, rows: np.ndarray | None, kinds: frozenset[str], pose: np.ndarray, posed: np.ndarray):
        """Lets the Empties of some kinds show their tissues, unless they are disabled in viewports.

        rows: their places among all objects of the file, or None where any of these is linked or overrides one: Blender
        then passes over a write to all, without a word. pose, posed: as the core's `Musculature.pose` has them.
        """
        self._shown.deltas(pose, posed, self._deltas)
        # an Empty moves with its origin bone by itself, so only a tissue that changed in its bone's space needs a write
        moved = (self._deltas != self._last).any(axis=1)
        due = [
            place
            for place in np.flatnonzero(moved).tolist()
            if self._kinds[place] in kinds and not empties[place].hide_viewport
        ]
        if not due:
            return
        self._last[due] = self._deltas[due]
        if rows is None:
            for place in due:
                self._write_one(empties[place], place)
            return
        for name in ("delta_location", "delta_scale", _ANGLES, "delta_rotation_quaternion"):
            own = [place for place in due if self._rotations[place] == name] if "rotation" in name else due
            if own:
                _write_in_bulk(name, rows[own], self._deltas[own, _COLUMNS[name]])
        for place in due:
            empties[place].update_tag(refresh=_TAG)

    def _write_one(self, empty, place: int):
        for name in ("delta_location", "delta_scale", self._rotations[place]):
            if name:
                setattr(empty, name, self._deltas[place, _COLUMNS[name]].tolist())


def _stacked(values: list, shape: tuple) -> np.ndarray:
    return np.array(values, np.float32).reshape(-1, *shape)


def _write_in_bulk(name: str, rows: np.ndarray, values: np.ndarray):
    """Gives some objects a property; all others of the file keep theirs.

    All at once, because a script that sets one value at a time waits for Blender's bookkeeping at each.
    """
    objects = bpy.data.objects
    present = np.empty((len(objects), values.shape[1]), np.float32)
    objects.foreach_get(name, present.reshape(-1))
    present[rows] = values
    objects.foreach_set(name, present.reshape(-1))


def show_rest(empty):
    """Takes the delta transforms away: the Empty is the rest-pose ellipsoid, carried by its origin bone alone."""
    for name, nothing in (
        ("delta_location", Vector()),
        ("delta_scale", Vector((1.0, 1.0, 1.0))),
        ("delta_rotation_quaternion", Quaternion()),
        ("delta_rotation_euler", Euler()),
    ):
        if getattr(empty, name) != nothing:
            setattr(empty, name, nothing)
