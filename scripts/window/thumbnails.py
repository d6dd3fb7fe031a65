"""Draws the thumbnails of the presets, addon/presets/thumbnails/*.png, each on a rig of its kind.

usage: blender --python scripts/window/thumbnails.py -- FOLDER

In a Blender with a window. The extension must be installed, and Rigify. `mogrify -colors 96 FOLDER/*.png` makes the files
small enough for the extension's zip.
"""

import sys
from pathlib import Path

sys.path.append(str(Path(__file__).resolve().parents[1]))

import bpy

from window import driver

FOLDER = Path(sys.argv[sys.argv.index("--") + 1])
METARIG_OF_PRESET = {
    **dict.fromkeys(("human", "limbs", "myo", "hand"), "human"),
    **dict.fromkeys(("cat", "toad"), "cat"),
    "quadruped": "wolf",
    "bird": "bird",
    "fish": "shark",
}


def begin():
    if "rigify" not in bpy.context.preferences.addons:
        bpy.ops.preferences.addon_enable(module="rigify")
    FOLDER.mkdir(parents=True, exist_ok=True)


def build(preset: str):
    def step():
        with driver.in_viewport():
            bpy.ops.object.select_all(action="SELECT")
            bpy.ops.object.delete()
            getattr(bpy.ops.object, f"armature_{METARIG_OF_PRESET[preset]}_metarig_add")()
            bpy.ops.sinew.add_preset(name=preset)
            bpy.context.object.sinew.rig.view = "MUSCLES"

    return step


def draw(preset: str):
    from bl_ext.user_default.sinew.display import shaded, thumbnail

    def step():
        rig = next(found for found in bpy.data.objects if found.type == "ARMATURE")
        with driver.in_viewport():
            assert thumbnail.write(FOLDER / f"{preset}.png", shaded.find(rig), bpy.context)

    return step


def steps_of(preset: str) -> list:
    return [build(preset), driver.wait, lambda: draw(preset)()]


driver.run([begin, *[step for preset in METARIG_OF_PRESET for step in steps_of(preset)]])
