# SPDX-License-Identifier: GPL-3.0-or-later
"""Colours of anatomy: red bellies, pale tendons, ivory bones. The chosen tissue is orange.

Each colour is a material, because every viewport shows materials by default.
"""

import bpy
import numpy as np

BELLY, TENDON, BONE, STUFFING, SPHERE, CHOSEN = range(6)
COLOUR_OF_KIND = {"MUSCLE": BELLY, "BONE": BONE, "STUFFING": STUFFING, "SPHERE": SPHERE}
# linear red, green, blue, in the order of the numbers above
DEFAULTS = (
    (0.42, 0.025, 0.02),
    (0.78, 0.70, 0.52),
    (0.72, 0.66, 0.50),
    (0.70, 0.47, 0.20),
    (0.45, 0.55, 0.60),
    (1.0, 0.35, 0.03),
)
_NAMES = ("Belly", "Tendon", "Bone", "Stuffing", "Sphere", "Chosen")
_ROUGHNESS = 0.45
_MARK = "sinew_anatomy_colour"

_colours = list(DEFAULTS)


def colour_of(number: int) -> tuple[float, float, float, float]:
    """A colour: linear red, green, blue and alpha."""
    return (*_colours[number], 1.0)


def set_colour(number: int, colour: tuple[float, float, float]):
    """Changes a colour, also in the materials of the file."""
    _colours[number] = colour
    for material in _own_materials():
        if material[_MARK] == number:
            _write(material, number)


def numbers_of(kinds: list[str]) -> np.ndarray:
    """(tissues,) int32: the colour of each tissue by its kind."""
    return np.array([COLOUR_OF_KIND[kind] for kind in kinds], np.int32)


def materials() -> list:
    """The materials of all colours. Creates those that the file does not have."""
    existing = {material[_MARK]: material for material in _own_materials()}
    return [existing.get(number) or _create(number) for number in range(len(DEFAULTS))]


def remove_unused():
    """Removes the materials that nothing uses."""
    for material in _own_materials():
        if not material.users:
            bpy.data.materials.remove(material)


def _own_materials() -> list:
    # while Blender starts and enables the extension, there is no data yet
    return [material for material in getattr(bpy.data, "materials", ()) if _MARK in material and not material.library]


def _create(number: int):
    material = bpy.data.materials.new(f"Sinew {_NAMES[number]}")
    material[_MARK] = number
    if material.node_tree is None:
        material.use_nodes = True
    _write(material, number)
    return material


def _write(material, number: int):
    material.diffuse_color, material.roughness = colour_of(number), _ROUGHNESS
    shader = material.node_tree.nodes.get("Principled BSDF")
    if shader:
        shader.inputs["Base Color"].default_value = colour_of(number)
        shader.inputs["Roughness"].default_value = _ROUGHNESS
