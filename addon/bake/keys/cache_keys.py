# SPDX-License-Identifier: GPL-3.0-or-later
"""A point cache turned into shape keys, one a sample, for what a farm baked and a file is to hold by itself."""

from collections.abc import Iterator

import bpy
import numpy as np

from ...errors import SinewError
from ...scene import mesh_arrays
from ..cache.playback import turned_back
from ..cache.point_cache import Timing
from ..scratch.scratch_mesh import BEFORE_ARMATURE, ScratchMesh
from .value_curves import key_values

PREFIX = "sinew_"


def add_keys(skin, scene, samples: np.ndarray, timing: Timing, up_axis: str) -> Iterator[float]:
    """Gives a skin the keys of a cache of points before the armature, with keyed values, and switches live off.

    A key holds basis + correction: what the mesh's own keys do at a frame is taken off. Between samples they cross-fade.
    Yields the part done, 0..1. Raises SinewError where the mesh has keys of these names or of an earlier bake, and then
    nothing has changed.
    """
    names = [f"{PREFIX}{frame:04d}" for frame in timing.frames]
    keys = skin.data.shape_keys
    taken = [name for name in names if keys and name in keys.key_blocks] or skin.sinew.skin.baked_keys.keys()
    if taken:
        raise SinewError(f"{skin.name} has the baked shape key '{taken[0]}' already: remove what was baked before")
    skin.sinew.skin.live = False
    scratch_mesh = ScratchMesh(scene, skin, BEFORE_ARMATURE)
    basis, shapes = mesh_arrays.read_points(skin.data), []
    try:
        for done, (frame, sample) in enumerate(zip(timing.frames, samples, strict=True), 1):
            scene.frame_set(frame)
            own = scratch_mesh.points(bpy.context.evaluated_depsgraph_get())
            shapes.append(basis + (turned_back(sample, up_axis) - own))
            yield done / len(samples)
    finally:
        scratch_mesh.remove()
    if keys is None:
        skin.shape_key_add(name="Basis", from_mix=False)
    for name, frame, shape in zip(names, timing.frames, shapes, strict=True):
        key = skin.shape_key_add(name=name, from_mix=False)
        key.relative_key = skin.data.shape_keys.reference_key
        key.points.foreach_set("co", shape.reshape(-1))
        key_values(
            skin.data.shape_keys,
            key,
            [(frame - timing.frames.step, 0.0), (frame, 1.0), (frame + timing.frames.step, 0.0)],
        )
        skin.sinew.skin.baked_keys.add().name = name
