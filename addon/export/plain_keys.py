# SPDX-License-Identifier: GPL-3.0-or-later
"""Makes the shape keys of a copied mesh plain, as file formats know them: offsets from the basis of every vertex.

A key of Blender may be masked by a vertex group, relative to another key, or muted. Exporters write the key's points and
nothing of that.
"""

import numpy as np

from ..bake.keys import key_store


def make_plain(copy):
    """Multiplies the masks of a mesh into its keys, makes all keys relative to the basis, and removes muted ones.

    The evaluated mesh does not change, at any value of any key.
    """
    keys = copy.data.shape_keys
    if keys is None:
        return
    points = {key.name: key_points(key) for key in keys.key_blocks}
    basis = points[keys.reference_key.name]
    masks: dict[str, np.ndarray] = {}
    for key in keys.key_blocks:
        if key == keys.reference_key:
            continue
        group = key.vertex_group
        is_masked = group in copy.vertex_groups  # Blender ignores the name of a group that does not exist
        if is_masked or key.relative_key != keys.reference_key:
            offsets = points[key.name] - points[key.relative_key.name]
            if is_masked:
                if group not in masks:
                    masks[group] = _weights(copy, copy.vertex_groups[group].index)
                offsets *= masks[group][:, None]
            key.points.foreach_set("co", (basis + offsets).reshape(-1))
        key.relative_key, key.vertex_group = keys.reference_key, ""
    for name in [key.name for key in keys.key_blocks if key.mute and key != keys.reference_key]:
        _remove(copy, name)


def _remove(copy, name: str):
    """Removes a key with its driver. An exporter stops at a driver that leads nowhere, and then writes no driven key."""
    keys = copy.data.shape_keys
    keys.driver_remove(key_store.value_path(name))
    copy.shape_key_remove(keys.key_blocks[name])


def key_points(key) -> np.ndarray:
    """The points of a key, (vertices, 3) float32, mesh space."""
    points = np.empty((len(key.points), 3), np.float32)
    key.points.foreach_get("co", points.reshape(-1))
    return points


def _weights(copy, group: int) -> np.ndarray:
    """The weights of a vertex group, (vertices,) float32; 0 outside the group. group: its index."""
    weights = np.zeros(len(copy.data.vertices), np.float32)
    for vertex in copy.data.vertices:
        for element in vertex.groups:
            if element.group == group:
                weights[vertex.index] = element.weight
    return weights
