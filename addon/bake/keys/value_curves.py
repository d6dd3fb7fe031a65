# SPDX-License-Identifier: GPL-3.0-or-later
"""Keyed values of shape keys, written as whole curves: one keyframe inserted at a time takes Blender longer with each."""

import numpy as np

from . import key_store

_LINEAR = 1  # of Blender's interpolations, as arrays have them


def key_values(keys, key, values: list[tuple[float, float]]):
    """Keys a shape key's value: (frame, value), rising, straight lines between; before the first and after the last it stays.

    keys: the mesh's shape keys. Keyframes that change nothing are left out.
    """
    needed = [
        point
        for place, point in enumerate(values)
        if not (0 < place < len(values) - 1 and values[place - 1][1] == point[1] == values[place + 1][1])
    ]
    frame, key.value = needed[0]
    key.keyframe_insert("value", frame=frame)
    path = key_store.value_path(key.name)
    curve = next(curve for curve in key_store.curves_of(keys) if curve.data_path == path)
    curve.keyframe_points.add(len(needed) - 1)
    curve.keyframe_points.foreach_set("co", np.array(needed, np.float32).reshape(-1))
    curve.keyframe_points.foreach_set("interpolation", np.full(len(needed), _LINEAR, np.int32))
    curve.update()
