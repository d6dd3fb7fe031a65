# SPDX-License-Identifier: GPL-3.0-or-later
"""Writes correctives to a mesh as shape keys with drivers."""

import numpy as np

from ...scene import mesh_arrays
from ..keys import key_store
from ..scratch import joint_turns
from ..scratch.joint_turns import JointTurn
from .corrective_drivers import TentWeight, drive, tent_at
from .skin_keys import SkinKeys

LONGEST_NAME = 63  # Blender's limit in bytes


def write_keys(rig, skin, keys: SkinKeys, turns: list[JointTurn], prefix: str) -> int:
    """Replaces the earlier correctives of the same joints by new keys. Returns how many keys of frames it mutes.

    turns: all turns of the bake.
    """
    joints = {turn.bone for turn in turns}
    for baked in [baked.name for baked in skin.sinew.skin.baked_keys if joints & set(baked.joints.split("\n"))]:
        key_store.remove_key(skin, baked)
    points = mesh_arrays.read_points(skin.data)
    active = skin.active_shape_key_index
    for turn, single in keys.single.items():
        for index, angle in enumerate(single.at):
            tents = [tent_at(turn, single.at, index)]
            _add(rig, skin, prefix + turn.label(angle), points + single.correction(index), tents)
    for first, second, pair in keys.pairs:
        for index, (row, column) in enumerate(pair.corners):
            label = f"{first.label(pair.first_at[row])} {second.label(pair.second_at[column])}"
            tents = [tent_at(first, pair.first_at, row), tent_at(second, pair.second_at, column)]
            _add(rig, skin, prefix + label, points + pair.correction(index), tents)
    skin.active_shape_key_index = active
    muted_keys = 0
    for baked in skin.sinew.skin.baked_keys:
        # The effects of keys of frames and of correctives would add up. Correctives that a bake of frames muted act again.
        muted_keys += not baked.joints and not baked.muted_by_sinew
        baked.muted_by_sinew = not baked.joints
    return muted_keys


def _add(rig, skin, name: str, points: np.ndarray, tents: list[TentWeight]):
    key = key_store.add_key(skin, name.encode()[:LONGEST_NAME].decode(errors="ignore"), points)
    drive(key, rig, tents)
    baked = skin.sinew.skin.baked_keys.add()
    baked.name, baked.joints = key.name, "\n".join(tent.turn.bone for tent in tents)
    baked.pose = joint_turns.to_json([(tent.turn, tent.peak) for tent in tents])
