# SPDX-License-Identifier: GPL-3.0-or-later
"""Refits the user's own shape keys to an export copy, so that they move its skin as they move the character's.

A key acts before the Armature modifier, which turns its offset o by the weighted mean of the vertex's bones. The copy has
other weights, for muscle bones too, and would turn it otherwise. Let A_t and B_t be the two linear maps of a vertex in frame
t, and v_t the value of the key. The new offset is the p that minimises

    sum over t of v_t^2 |B_t p - A_t o|^2 + h |p - o|^2.
"""

import bpy
import _sinew
import numpy as np

from .plain_keys import key_points

# the weight h of the old offset, relative to the sum of v_t^2: small, and keeps p defined where bones flatten the skin
_HOLD = 1e-3


def own_keys(skin) -> list[str]:
    """The names of the keys of a mesh that Sinew did not bake, without the basis."""
    keys = skin.data.shape_keys
    if keys is None:
        return []
    baked = {entry.name for entry in skin.sinew.skin.baked_keys}
    return [key.name for key in keys.key_blocks if key != keys.reference_key and key.name not in baked and not key.mute]


def values_of(skin, names: list[str]) -> list[float]:
    """The values of keys in the current frame, as Blender evaluates them."""
    if not names:
        return []
    evaluated = skin.evaluated_get(bpy.context.evaluated_depsgraph_get()).data.shape_keys.key_blocks
    return [evaluated[name].value for name in names]


def refit(
    copy, original: _sinew.LinearSkin, linear: _sinew.LinearSkin, poses: np.ndarray, names: list[str], values: np.ndarray
):
    """Gives keys of a copy their new offsets.

    original: the skin with the character's weights, linear: with the copy's. poses: (frames, bones, 4, 4) float32, column-
    major, of the copy. values: (frames, keys), those of `names`.
    """
    keys = copy.data.shape_keys
    own = [
        _OwnKey(keys.key_blocks[name], values[:, index] ** 2) for index, name in enumerate(names) if values[:, index].any()
    ]
    for frame, pose in enumerate(poses):
        acting = [key for key in own if key.weights[frame]]
        if acting:
            a, b = (_maps(skin, pose, len(copy.data.vertices)) for skin in (original, linear))
            for key in acting:
                key.add(frame, a, b)
    for key in own:  # after all are read: a key may be relative to another
        key.write()


class _OwnKey:
    """A key, its offsets, and the sums of the normal equations for the vertices that it moves.

    weights: (frames,) float64, the squares of its values, which are not all 0.
    """

    def __init__(self, key, weights: np.ndarray):
        self._key, self.weights = key, weights
        self._points = key_points(key)
        offsets = self._points.astype(np.float64) - key_points(key.relative_key)
        self._rows = np.flatnonzero(offsets.any(axis=1))
        self._offsets = offsets[self._rows]
        self._normal = np.zeros((len(self._rows), 3, 3))  # sum of v^2 B^T B
        self._mixed = np.zeros_like(self._normal)  # sum of v^2 B^T A

    def add(self, frame: int, a: np.ndarray, b: np.ndarray):
        """Adds a frame. a, b: the maps of all vertices, (vertices, 3, 3)."""
        a, b = a[self._rows], b[self._rows]
        transposed = self.weights[frame] * np.swapaxes(b, 1, 2)
        self._normal += transposed @ b
        self._mixed += transposed @ a

    def write(self):
        """Writes the key with its new offsets."""
        hold = _HOLD * self.weights.sum() * np.eye(3)
        new = np.linalg.solve(self._normal + hold, (self._mixed + hold) @ self._offsets[:, :, None])[:, :, 0]
        self._points[self._rows] += (new - self._offsets).astype(np.float32)
        self._key.points.foreach_set("co", self._points.reshape(-1))


def _maps(skin: _sinew.LinearSkin, pose: np.ndarray, count: int) -> np.ndarray:
    """The linear map of each vertex in a pose, (vertices, 3, 3) float64."""
    offsets, origin = np.zeros((count, 3), np.float32), np.empty((count, 3), np.float32)
    skin.deform(pose, offsets, origin)
    maps = np.empty((count, 3, 3))
    for axis in range(3):
        offsets[:] = np.eye(3, dtype=np.float32)[axis]
        posed = np.empty_like(origin)
        skin.deform(pose, offsets, posed)
        maps[:, :, axis] = posed.astype(np.float64) - origin
    return maps
