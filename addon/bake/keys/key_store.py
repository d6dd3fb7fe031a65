# SPDX-License-Identifier: GPL-3.0-or-later
"""The shape keys that Sinew baked, of whatever kind: known by name in the mesh's settings, muted where they must not act, removed
with the animation and the drivers that play them.
"""

import bpy
import numpy as np

from ...errors import SinewError
from ...scene import armature_modifier, stored_settings

LONGEST_PREFIX = 48


def check_bakeable(skins: list, prefix: str):
    """Raises SinewError for a mesh that can't take baked keys, or a prefix that leaves no room for a name, saying what to do."""
    if len(prefix.encode()) > LONGEST_PREFIX:
        raise SinewError(
            f"The prefix '{prefix}' is longer than {LONGEST_PREFIX} characters, too long for a shape key's name"
        )
    for skin in skins:
        if not armature_modifier.is_bound(skin):
            raise SinewError(f"{skin.name} is not bound: bind it first (Bind Skin)")
        if skin.library or skin.data.library:
            raise SinewError(
                f"{skin.name} is linked from another file and can't hold new keys: make it local, or bake it there"
            )
        if skin.data.is_editmode:
            raise SinewError(f"{skin.name} is in Edit Mode: leave it (Tab) and bake again")
        keys = skin.data.shape_keys
        if keys and not keys.use_relative:
            raise SinewError(f"{skin.name} has absolute shape keys, which add nothing: make them relative")


def refuse_foreign(skin, names):
    """Raises SinewError where the mesh has a key of one of these names that Sinew did not bake."""
    keys = skin.data.shape_keys
    ours = {baked.name for baked in stored_settings.baked_keys_of(skin)}
    for name in names:
        if keys and name in keys.key_blocks and name not in ours:
            raise SinewError(f"{skin.name} has a shape key '{name}' of its own: choose another prefix")


def add_key(skin, name: str, points):
    """A new key of this name, relative to the basis and without effect yet; points: (vertices, 3) float32. A basis first, where
    the mesh has no keys.
    """
    if skin.data.shape_keys is None:
        skin.shape_key_add(name="Basis", from_mix=False)
    key = skin.shape_key_add(name=name, from_mix=False)
    key.relative_key = skin.data.shape_keys.reference_key
    key.value = 0.0
    key.points.foreach_set("co", points.reshape(-1))
    return key


def mm_per_metre(skin) -> float:
    """mm in the world of the longest direction of a metre in the mesh."""
    return 1000.0 * float(np.linalg.norm(np.array(skin.matrix_world.to_3x3()), 2))


def value_path(name: str) -> str:
    """Where a key's value stands, from its mesh's shape keys."""
    return f'key_blocks["{bpy.utils.escape_identifier(name)}"].value'


def remove_baked(skin):
    """Removes all keys that Sinew baked into a mesh, their animation, and the basis where nothing else needs it."""
    names = [baked.name for baked in stored_settings.baked_keys_of(skin)]
    for name in names:
        remove_key(skin, name)
    remove_basis_of_ours(skin, had_keys=not names)
    _remove_empty_action(skin.data.shape_keys)


def remove_key(skin, name: str):
    """Removes a baked key with what plays it."""
    keys = skin.data.shape_keys
    if keys:
        path = value_path(name)
        curves = curves_of(keys)
        for curve in [curve for curve in curves if curve.data_path == path]:
            curves.remove(curve)
        key = keys.key_blocks.get(name)
        if key:
            key.driver_remove("value")
            skin.shape_key_remove(key)
    index = skin.sinew.skin.baked_keys.find(name)
    if index >= 0:
        skin.sinew.skin.baked_keys.remove(index)


def remove_basis_of_ours(skin, had_keys: bool):
    """Removes the basis where no other key is left and the mesh had none before."""
    keys = skin.data.shape_keys
    if keys and not had_keys and len(keys.key_blocks) == 1 and not stored_settings.baked_keys_of(skin):
        action = keys.animation_data.action if keys.animation_data else None
        skin.shape_key_clear()
        if action and action.users == 0:
            bpy.data.actions.remove(action)


def _remove_empty_action(keys):
    """Takes an action away that nothing is left in, as where the baked keys were all that was keyed."""
    animation = keys.animation_data if keys else None
    action = animation.action if animation else None
    if animation is None or (action and _has_curves(action)):
        return
    if not animation.nla_tracks and not animation.drivers:
        keys.animation_data_clear()
    if action and action.users == 0:
        bpy.data.actions.remove(action)


def _has_curves(action) -> bool:
    return any(bag.fcurves for layer in action.layers for strip in layer.strips for bag in strip.channelbags)


def curves_of(keys):
    """The function curves that play a mesh's shape keys; an empty list without animation."""
    animation = keys.animation_data
    if animation is None or animation.action is None or animation.action_slot is None:
        return []
    for layer in animation.action.layers:
        for strip in layer.strips:
            channels = strip.channelbag(animation.action_slot)
            if channels:
                return channels.fcurves
    return []
