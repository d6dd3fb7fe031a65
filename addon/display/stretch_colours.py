# SPDX-License-Identifier: GPL-3.0-or-later
"""Colors of muscle stretch: blue for shortened, white for the rest length, red for lengthened.

Each step is a material, because every viewport shows materials by default.
"""

import bpy
import numpy as np

STEPS = 11
FULL_COLOUR_CHANGE = 0.4  # muscles at 60 % and 140 % of the rest length have the full colors
_SHORTENED, _AT_REST, _LENGTHENED = np.array(((0.05, 0.15, 0.8), (0.9, 0.9, 0.9), (0.8, 0.05, 0.05)))
_NAME = "Sinew Stretch"
_MARK = "sinew_stretch_step"


def steps_of(stretch: np.ndarray) -> np.ndarray:
    """(ellipsoids,) int32: the step of each stretch. 0 is the shortest."""
    middle = STEPS // 2
    steps = np.rint((stretch - 1.0) / FULL_COLOUR_CHANGE * middle) + middle
    return np.clip(steps, 0, STEPS - 1).astype(np.int32)


def colour_of(step: int) -> tuple[float, float, float, float]:
    """The color of a step: linear red, green, blue and alpha."""
    blend = step / (STEPS // 2) - 1.0
    end = _SHORTENED if blend < 0.0 else _LENGTHENED
    return (*(_AT_REST + (end - _AT_REST) * abs(blend)), 1.0)


def materials() -> list:
    """The materials of all steps. Creates those that the file does not have."""
    existing = {material[_MARK]: material for material in _own_materials()}
    return [existing.get(step) or _create(step) for step in range(STEPS)]


def remove_unused():
    """Removes the materials that nothing uses."""
    for material in _own_materials():
        if not material.users:
            bpy.data.materials.remove(material)


def _own_materials() -> list:
    return [material for material in bpy.data.materials if _MARK in material and not material.library]


def _create(step: int):
    material = bpy.data.materials.new(f"{_NAME} {step + 1}")
    material[_MARK] = step
    material.diffuse_color = colour_of(step)
    if material.node_tree is None:
        material.use_nodes = True
    material.node_tree.nodes["Principled BSDF"].inputs["Base Color"].default_value = colour_of(step)
    return material
