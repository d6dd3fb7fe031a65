# SPDX-License-Identifier: GPL-3.0-or-later
"""The rest body of a mesh as Blender shows it: shape keys in their values, without the vertices that a Mask modifier hides.

MPFB and Daz keep the proportions of a body in the values of shape keys, so the basis is another body. The keys that form the
rest body are those that are not 0 when the mesh is bound; later values of these keys count, too. Keys that play do not
count: keys with keyframes, and keys whose drivers depend on bones or on keyed properties, are expressions and correctives.
They add to the bound skin, as a key does that is raised later.
"""

import _sinew
import numpy as np
from mathutils import Matrix

from . import mesh_arrays, stored_settings


def read_points(skin) -> np.ndarray:
    """(vertices, 3) float32: the rest points of a mesh object in mesh space, with the shape keys that do not play."""
    points = mesh_arrays.read_points(skin.data)
    values = key_values(skin)
    if not values:
        return points
    keys = skin.data.shape_keys.key_blocks
    # read once, since a key can be relative to a key that is also shown
    positions = {"": points}
    shown = points.copy()
    for name, value in values:
        key = keys[name]
        offset = _positions(key, positions) - _positions(key.relative_key, positions)
        factors = _group_weights(skin, key.vertex_group) * value if key.vertex_group else value
        shown += offset * factors
    return shown.astype(np.float32)


def key_values(skin) -> tuple[tuple[str, float], ...]:
    """The names and values of the shape keys that form the rest body of a mesh object.

    For a bound mesh, those of `object.sinew.skin.body_keys`; else `shown_keys`.
    """
    if not skin.data.shape_keys or not skin.data.shape_keys.use_relative:
        return ()
    settings = stored_settings.skin_of(skin)
    if settings is None or not settings.bound:
        return shown_keys(skin)
    keys = skin.data.shape_keys.key_blocks
    names = (name for name in settings.body_keys.split("\n") if name in keys)
    return tuple((name, keys[name].value) for name in names if keys[name].value and not keys[name].mute)


def shown_keys(skin) -> tuple[tuple[str, float], ...]:
    """The names and values of the shape keys that are not 0 and do not play."""
    keys = skin.data.shape_keys
    if not keys or not keys.use_relative:
        return ()
    values = np.empty(len(keys.key_blocks), np.float32)
    keys.key_blocks.foreach_get("value", values)
    values[0] = 0.0
    baked = {baked.name for baked in stored_settings.baked_keys_of(skin)}
    shown = [keys.key_blocks[index] for index in np.flatnonzero(values).tolist()]
    shown = [key for key in shown if not key.mute and key.name not in baked]
    return tuple((key.name, key.value) for key in shown if not _is_playing(keys.animation_data, key))


def shown_vertices(skin) -> np.ndarray | None:
    """(vertices,) bool: the vertices that no Mask modifier hides in both viewport and render. None if none is hidden.

    Masks by bone selection are skipped: they follow the selection.
    """
    shown = None
    for modifier in skin.modifiers:
        if modifier.type != "MASK" or modifier.mode != "VERTEX_GROUP":
            continue
        if not (modifier.show_viewport and modifier.show_render) or modifier.vertex_group not in skin.vertex_groups:
            continue
        is_kept = _group_weights(skin, modifier.vertex_group)[:, 0] > modifier.threshold
        is_kept = ~is_kept if modifier.invert_vertex_group else is_kept
        shown = is_kept if shown is None else shown & is_kept
    return None if shown is None or shown.all() else shown


def shown_only(rows: np.ndarray, shown: np.ndarray | None) -> np.ndarray:
    """The rows of vertex indices, such as edges or triangles, whose vertices are all shown. shown: as `shown_vertices`."""
    return rows if shown is None else np.ascontiguousarray(rows[shown[rows].all(axis=1)])


def mask_state(skin) -> tuple:
    """The settings of a mesh's Mask modifiers that its rest body depends on."""
    return tuple(
        (mask.mode, mask.vertex_group, mask.invert_vertex_group, mask.threshold, mask.show_viewport, mask.show_render)
        for mask in skin.modifiers
        if mask.type == "MASK"
    )


def read_polygons(skin, to_space: Matrix | None = None) -> _sinew.PolygonMesh:
    """The shown faces of a mesh object with its rest points, taken from mesh space to another space by `to_space`."""
    column_major = None if to_space is None else np.ascontiguousarray(np.array(to_space, np.float32).T)
    corners, offsets = mesh_arrays.read_corners(skin.data)
    shown = shown_vertices(skin)
    if shown is not None:
        sizes = np.diff(offsets)
        is_face_shown = np.logical_and.reduceat(shown[corners], offsets[:-1]) if len(sizes) else np.zeros(0, bool)
        corners = corners[np.repeat(is_face_shown, sizes)]
        offsets = np.concatenate(([0], np.cumsum(sizes[is_face_shown]))).astype(np.int32)
    return _sinew.PolygonMesh(read_points(skin), corners, offsets, column_major)


def _positions(key, read: dict[str, np.ndarray]) -> np.ndarray:
    if key.name not in read:
        positions = np.empty((len(key.points), 3), np.float32)
        key.points.foreach_get("co", positions.reshape(-1))
        read[key.name] = positions
    return read[key.name]


def _group_weights(skin, name: str) -> np.ndarray:
    """(vertices, 1) float32: the weights of a vertex group, 0 outside of it; 1 if there is no such group."""
    weights = np.zeros((len(skin.data.vertices), 1), np.float32)
    group = skin.vertex_groups.get(name)
    if group is None:
        return weights + 1.0
    for index, vertex in enumerate(skin.data.vertices):
        for element in vertex.groups:
            if element.group == group.index:
                weights[index] = element.weight
    return weights


def _is_playing(animation, key) -> bool:
    """Whether the value of a key has keyframes, or a driver that depends on something that moves."""
    if animation is None:
        return False
    path = key.path_from_id("value")
    curve = animation.drivers.find(path)
    return _is_keyed(animation, path) or (curve is not None and _is_moving(curve.driver))


def _is_moving(driver) -> bool:
    """Whether a driver depends on a transform, a bone, the time or a keyed property. Others are sliders of the body."""
    if driver.type == "SCRIPTED" and "frame" in driver.expression:
        return True
    for variable in driver.variables:
        if variable.type != "SINGLE_PROP":
            return True
        for target in variable.targets:
            if target.id is None or target.data_path.startswith("pose.bones"):
                return True
            animation = getattr(target.id, "animation_data", None)
            if animation and _is_keyed(animation, target.data_path):
                return True
    return False


def _is_keyed(animation, path: str) -> bool:
    """Whether the action or a strip of the Nonlinear Animation has a curve for a property."""
    actions = [animation.action] + [strip.action for track in animation.nla_tracks for strip in track.strips]
    bags = (
        bag
        for action in actions
        if action is not None
        for layer in action.layers
        for strip in layer.strips
        for bag in strip.channelbags
    )
    return any(bag.fcurves.find(path) is not None for bag in bags)
