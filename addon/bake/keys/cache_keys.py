# SPDX-License-Identifier: GPL-3.0-or-later
"""Converts a point cache to shape keys, one per sample, so that a .blend file plays a farm's bake without other files."""

from collections.abc import Iterator

import bpy
import numpy as np

from ...errors import SinewError
from ...scene import mesh_arrays
from ...scene.current_frame import time_per_frame, visit_frames
from ..cache.playback import from_up_axis
from ..cache.point_cache import Timing
from ..scratch.scratch_mesh import BEFORE_ARMATURE, ScratchMesh
from . import key_store
from .value_curves import key_values

PREFIX = "sinew_"


def add_keys(skin, scene, samples: np.ndarray, timing: Timing, up_axis: str) -> Iterator[float]:
    """Gives a skin the samples of a point cache as keys with animated values, and switches Live off.

    samples: (samples, vertices, 3) float32, the points before the Armature modifier. A key holds the basis plus the
    correction: the effect of the mesh's other keys at that frame is subtracted. Between samples the keys cross-fade.
    Yields the fraction done, 0..1. Raises SinewError, without any change, if the mesh has keys with these names or keys
    of an earlier bake.
    """
    names = [f"{PREFIX}{frame:04d}" for frame in timing.frames]
    keys = skin.data.shape_keys
    taken = [name for name in names if keys and name in keys.key_blocks] or skin.sinew.skin.baked_keys.keys()
    if taken:
        raise SinewError(f"{skin.name} already has the baked shape key '{taken[0]}'. Remove the earlier bake first")
    skin.sinew.skin.live = False
    scratch_mesh = ScratchMesh(scene, skin, BEFORE_ARMATURE)
    basis, shapes = mesh_arrays.read_points(skin.data), []
    try:
        with visit_frames(scene) as go_to:
            for done, (frame, sample) in enumerate(zip(timing.frames, samples, strict=True), 1):
                go_to(frame)
                uncorrected = scratch_mesh.points(bpy.context.evaluated_depsgraph_get())
                shapes.append(basis + (from_up_axis(sample, up_axis) - uncorrected))
                yield done / len(samples)
    finally:
        scratch_mesh.remove()
    for name, frame, shape in zip(names, timing.frames, shapes, strict=True):
        key = key_store.add_key(skin, name, shape)
        key_values(
            skin.data.shape_keys,
            key,
            [(frame - timing.frames.step, 0.0), (frame, 1.0), (frame + timing.frames.step, 0.0)],
            time_per_frame(scene),
        )
        skin.sinew.skin.baked_keys.add().name = name
