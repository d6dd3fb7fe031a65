"""The animals that the demos and pictures grow a skin for: armature, preset and the options of Grow Skin."""

from collections.abc import Callable
from dataclasses import dataclass

import bpy
import addon_utils

from demos import hand_rig, toad_rig


def _metarig(name: str) -> Callable:
    def made():
        getattr(bpy.ops.object, f"armature_{name}_metarig_add")()
        return bpy.context.object

    return made


@dataclass(frozen=True)
class Animal:
    """armature: makes it and returns it. growth: options of Grow Skin. coat: the color of its skin. left_out: first words of
    features that it does not have."""

    armature: Callable
    preset: str
    growth: dict
    coat: tuple[float, float, float, float]
    left_out: tuple[str, ...] = ()


# The resolution is that of the pictures; the cat of Wilhelms 1997 had 83. The filter fills what fur and fat fill.
ANIMALS = {
    "cat": Animal(
        _metarig("cat"), "cat", {"resolution": 220, "thickness": 0.003, "smoothing": 8, "radius": 2}, (0.52, 0.31, 0.14, 1)
    ),
    "dog": Animal(
        _metarig("wolf"),
        "quadruped",
        {"resolution": 220, "thickness": 0.009, "smoothing": 8, "radius": 2},
        (0.36, 0.27, 0.19, 1),
    ),
    "horse": Animal(
        _metarig("horse"),
        "quadruped",
        {"resolution": 200, "thickness": 0.015, "smoothing": 8, "radius": 2},
        (0.24, 0.11, 0.05, 1),
    ),
    "toad": Animal(
        toad_rig.make,
        "toad",
        {"resolution": 120, "thickness": 0.001, "smoothing": 8},
        (0.30, 0.27, 0.12, 1),
        left_out=("Claw",),
    ),
    "hand": Animal(
        hand_rig.make,
        "hand",
        {"resolution": 240, "thickness": 0.0018, "smoothing": 6, "features": False},
        (0.60, 0.37, 0.28, 1),
    ),
    "human": Animal(
        _metarig("human"), "human", {"resolution": 110, "thickness": 0.008, "smoothing": 8, "features": False},
        (0.60, 0.37, 0.28, 1),
    ),
}  # fmt: skip


def grow(name: str, **options):
    """A new file with the animal's armature, its muscles and a skin grown over them; returns the armature and the skin.

    options: of Grow Skin, instead of the animal's own.
    """
    animal = ANIMALS[name]
    bpy.ops.wm.read_factory_settings(use_empty=True)
    addon_utils.enable("rigify", default_set=True)
    rig = animal.armature()
    bpy.ops.sinew.add_preset(name=animal.preset)
    growth = animal.growth | options
    bpy.ops.sinew.grow_skin(**growth)
    unwanted = [found for found in bpy.data.objects if found.name.split(" ")[0].split(".")[0] in animal.left_out]
    if unwanted:
        for found in (*unwanted, _skin()):
            bpy.data.objects.remove(found)
        bpy.context.view_layer.update()
        bpy.ops.sinew.grow_skin(**growth | {"features": False})  # those that are left are tissues of the armature now
    skin = _skin()
    if skin.data.materials:
        material = skin.data.materials[0]
        material.diffuse_color = animal.coat
        shader = next(node for node in material.node_tree.nodes if node.type == "BSDF_PRINCIPLED")
        shader.inputs["Base Color"].default_value = animal.coat
    return rig, skin


def _skin():
    return next(found for found in bpy.data.objects if found.type == "MESH" and found.sinew.skin.growth.is_grown)
