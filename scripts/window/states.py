"""Pictures of the states that a person sees, each checked for what it must show.

usage: blender --python scripts/window/states.py -- FOLDER

The extension must be installed, and xdotool and ImageMagick. The pictures are written to FOLDER. The checks compare
quantities that do not depend on the driver of the graphics card: how much of the viewport is red as a belly is, and how much
differs from the state before.
"""

import sys
from pathlib import Path

sys.path.append(str(Path(__file__).resolve().parents[1]))

import bpy
import numpy as np

from window import driver

FOLDER = Path(sys.argv[sys.argv.index("--") + 1])
_pictures: dict[str, np.ndarray] = {}


def rig():
    return next(found for found in bpy.data.objects if found.type == "ARMATURE")


def empty_file():
    with driver.in_viewport():
        bpy.ops.object.select_all(action="SELECT")
        bpy.ops.object.delete()


def example():
    with driver.in_viewport():
        bpy.ops.sinew.example_character()
        bpy.ops.view3d.view_axis(type="FRONT")
        bpy.ops.view3d.view_all()


def view(name: str):
    def step():
        with driver.in_viewport():
            rig().sinew.rig.view = name

    return step


def shading(name: str):
    def step():
        driver.parts()[1].spaces.active.shading.type = name

    return step


def bend():
    with driver.in_viewport():
        bpy.ops.sinew.repair(what="POSE_MODE", name=rig().name)
        for side in "LR":
            bone = rig().pose.bones[f"forearm.{side}"]
            bone.rotation_mode = "XYZ"
            bone.rotation_euler.x = 1.5


def object_mode():
    with driver.in_viewport():
        bpy.ops.object.mode_set(mode="OBJECT")


def choose():
    from bl_ext.user_default.sinew.scene import selection

    with driver.in_viewport():
        selection.select(bpy.data.objects["Biceps brachii, long head.L"])
        bpy.context.window_manager.sinew_show_moved = True


def red_fraction(pixels: np.ndarray) -> float:
    """The fraction of the viewport that is red as muscles are, also through the skin."""
    red, green, blue = (pixels[..., channel] for channel in range(3))
    return float(((red > 1.6 * green) & (red > 1.6 * blue) & (red > 0.2)).mean())


def state(name: str, check=None):
    """A step that takes the picture of a state and checks it."""

    def step():
        _pictures[name] = driver.picture(FOLDER / f"{name}.png")
        print(f"{name}: {100.0 * red_fraction(_pictures[name]):.2f} % red", flush=True)
        if check:
            check(_pictures[name])

    return step


def shows_muscles(pixels: np.ndarray):
    assert red_fraction(pixels) > 0.01, red_fraction(pixels)


def shows_no_muscles(pixels: np.ndarray):
    assert red_fraction(pixels) < 0.005, red_fraction(pixels)  # the X axis is red


def differs_from(name: str, least: float):
    """A check that at least a fraction of the viewport differs from another state."""

    def check(pixels: np.ndarray):
        changed = float((np.abs(pixels - _pictures[name]).max(axis=2) > 0.1).mean())
        assert changed > least, (name, changed)

    return check


FOLDER.mkdir(parents=True, exist_ok=True)
driver.run(
    [
        empty_file, driver.open_sidebar, driver.wait, driver.open_tab, driver.wait,
        state("1_empty", shows_no_muscles),
        example, driver.wait, driver.wait,
        state("2_first_muscles", shows_muscles),
        view("MUSCLES"), driver.wait, state("3_muscles", shows_muscles),
        view("SKIN"), driver.wait, state("4_skin", shows_no_muscles),
        view("XRAY"), bend, driver.wait, state("5_bent_in_xray", differs_from("2_first_muscles", 0.005)),
        object_mode, choose, driver.wait, state("6_heat_map", differs_from("5_bent_in_xray", 0.001)),
        shading("MATERIAL"), *[driver.wait] * 15, state("7_material", shows_muscles),
        shading("SOLID"), view("SKIN"), driver.wait, state("8_bent_skin", differs_from("4_skin", 0.005)),
    ]
)  # fmt: skip
