# SPDX-License-Identifier: GPL-3.0-or-later
"""The shape keys that Sinew baked, of frames and of joints: how they are added to a mesh, found and removed.

The mesh's settings list them by name. Removing a key also removes the animation or driver of its value.
"""

import bpy
import numpy as np

from ...errors import SinewError
from ...scene import stored_settings
from .. import requirements

LONGEST_PREFIX = 48


def check_bakeable(skins: list, prefix: str):
    """Raises SinewError if a mesh can't take baked keys or the prefix is too long for the name of a key."""
    if len(prefix.encode()) > LONGEST_PREFIX:
        raise SinewError(
            f"The prefix '{prefix}' is longer than {LONGEST_PREFIX} characters, too long for a shape key's name"
        )
    for skin in skins:
        requirements.require_bound(skin)
        if skin.library or skin.data.library:
            raise SinewError(
                f"{skin.name} is linked from another file and can't hold new keys. Make it local, or bake it in that file"
            )
        if _names_from_library(skin):
            raise SinewError(
                f"{skin.name} overrides an object with baked keys, which only its own file can replace. Make the object "
                "local (Object > Relations > Make Local), or bake it in that file"
            )
        requirements.require_object_mode(skin)
        keys = skin.data.shape_keys
        if keys and not keys.use_relative:
            raise SinewError(f"{skin.name} has absolute shape keys, to which no correction can be added. Make them relative")


def refuse_foreign(skin, names):
    """Raises SinewError if the mesh has a key with one of these names that Sinew did not bake."""
    keys = skin.data.shape_keys
    ours = {baked.name for baked in stored_settings.baked_keys_of(skin)}
    for name in names:
        if keys and name in keys.key_blocks and name not in ours:
            raise SinewError(f"{skin.name} has a shape key '{name}' that Sinew did not bake. Choose another prefix")


def add_key(skin, name: str, points):
    """Adds a key relative to the basis, with value 0, and returns it. Adds a basis if the mesh has no keys.

    points: (vertices, 3) float32, the key's shape in mesh space.
    """
    if skin.data.shape_keys is None:
        skin.shape_key_add(name="Basis", from_mix=False)
    key = skin.shape_key_add(name=name, from_mix=False)
    key.relative_key = skin.data.shape_keys.reference_key
    key.value = 0.0
    key.points.foreach_set("co", points.reshape(-1))
    return key


def mm_per_metre(skin) -> float:
    """The largest length, in mm in the world, of a vector of one metre in mesh space. skin: evaluated, if it is animated."""
    return 1000.0 * float(np.linalg.norm(np.array(skin.matrix_world.to_3x3()), 2))


def value_path(name: str) -> str:
    """The data path of a key's value, relative to the mesh's shape keys."""
    return f'key_blocks["{bpy.utils.escape_identifier(name)}"].value'


def remove_baked(skin):
    """Removes all baked keys of a mesh with their animation, and the basis if nothing else needs it."""
    names = [baked.name for baked in stored_settings.baked_keys_of(skin)]
    for name in names:
        remove_key(skin, name)
    _remove_unused_basis(skin, had_keys=not names)
    _remove_empty_action(skin.data.shape_keys)


def remove_key(skin, name: str):
    """Removes a baked key with the animation or driver of its value."""
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
    if index >= 0 and name not in _names_from_library(skin):
        skin.sinew.skin.baked_keys.remove(index)


def _names_from_library(skin) -> set[str]:
    """The names of baked keys that an override has from its library, and that Blender does not let it remove."""
    override = skin.override_library
    original = override.reference if override else None
    return {baked.name for baked in stored_settings.baked_keys_of(original)} if original else set()


def _remove_unused_basis(skin, had_keys: bool):
    """Removes the basis if it is the only key left and the mesh had no keys before Sinew baked some."""
    keys = skin.data.shape_keys
    if keys and not had_keys and len(keys.key_blocks) == 1 and not stored_settings.baked_keys_of(skin):
        action = keys.animation_data.action if keys.animation_data else None
        skin.shape_key_clear()
        if action and action.users == 0:
            bpy.data.actions.remove(action)


def _remove_empty_action(keys):
    """Removes the action of shape keys if no curve is left in it."""
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
    """Returns the animation curves of a mesh's shape keys; an empty list if they are not animated."""
    animation = keys.animation_data
    if animation is None or animation.action is None or animation.action_slot is None:
        return []
    for layer in animation.action.layers:
        for strip in layer.strips:
            channels = strip.channelbag(animation.action_slot)
            if channels:
                return channels.fcurves
    return []
