# SPDX-License-Identifier: GPL-3.0-or-later
"""Colours of stretch: blue for shortened, white for the rest length, red for lengthened.

They are materials, one a step, because those are what every viewport shows without being told to.
"""

import bpy
import numpy as np

STEPS = 11
FARTHEST_STRETCH = 0.4  # beyond 60 % and 140 % of the rest length the colours end
_SHORTENED, _AT_REST, _LENGTHENED = np.array(((0.05, 0.15, 0.8), (0.9, 0.9, 0.9), (0.8, 0.05, 0.05)))
_NAME = "Sinew Stretch"
_MARK = "sinew_stretch_step"


def steps_of(stretch: np.ndarray) -> np.ndarray:
    """(ellipsoids,) int32: the step of each stretch, 0 for the shortest."""
    middle = STEPS // 2
    steps = np.rint((stretch - 1.0) / FARTHEST_STRETCH * middle) + middle
    return np.clip(steps, 0, STEPS - 1).astype(np.int32)


def colour_of(step: int) -> tuple[float, float, float, float]:
    """Linear red, green, blue, alpha."""
    share = step / (STEPS // 2) - 1.0
    end = _SHORTENED if share < 0.0 else _LENGTHENED
    return (*(_AT_REST + (end - _AT_REST) * abs(share)), 1.0)


def materials() -> list:
    """The materials of all steps, those of this file or new ones."""
    present = {found[_MARK]: found for found in bpy.data.materials if _MARK in found and not found.library}
    return [present.get(step) or _create(step) for step in range(STEPS)]


def remove_unused():
    """Removes the materials that nothing uses any more."""
    for found in [found for found in bpy.data.materials if _MARK in found and not found.library and not found.users]:
        bpy.data.materials.remove(found)


def _create(step: int):
    material = bpy.data.materials.new(f"{_NAME} {step + 1}")
    material[_MARK] = step
    material.diffuse_color = colour_of(step)
    if material.node_tree is None:
        material.use_nodes = True
    material.node_tree.nodes["Principled BSDF"].inputs["Base Color"].default_value = colour_of(step)
    return material
