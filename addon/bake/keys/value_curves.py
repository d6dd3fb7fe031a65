# SPDX-License-Identifier: GPL-3.0-or-later
"""Animation curves of shape key values, written as whole curves.

Inserting keyframes one by one takes Blender longer with each keyframe.
"""

import numpy as np

from . import key_store

LINEAR = 1  # Blender's interpolation LINEAR as a number, for foreach_set


def key_values(keys, key, values: list[tuple[float, float]], time_per_frame: float):
    """Animates a shape key's value linearly between keyframes, and constantly before the first and after the last.

    keys: the mesh's shape keys. values: (frame, value), frames increasing. Keyframes that change nothing are left out.
    time_per_frame: as from `current_frame.time_per_frame`.
    """
    needed = [
        (point[0] * time_per_frame, point[1])
        for index, point in enumerate(values)
        if not (0 < index < len(values) - 1 and values[index - 1][1] == point[1] == values[index + 1][1])
    ]
    time, key.value = needed[0]
    key.keyframe_insert("value", frame=time)
    path = key_store.value_path(key.name)
    curve = next(curve for curve in key_store.curves_of(keys) if curve.data_path == path)
    curve.keyframe_points.add(len(needed) - 1)
    curve.keyframe_points.foreach_set("co", np.array(needed, np.float32).reshape(-1))
    curve.keyframe_points.foreach_set("interpolation", np.full(len(needed), LINEAR, np.int32))
    curve.update()
