"""Pictures of ten states that a person sees, each checked for what it must show and compared with a reference.

usage: blender --python scripts/window/states.py -- FOLDER [--update]

The extension must be installed, and xdotool and ImageMagick. The pictures are written to FOLDER. The checks compare
quantities that do not depend on the driver of the graphics card: how much of the viewport is red as a belly is, and how much
differs from the state before. The references are small pictures of the viewport, so that lines and letters hardly count;
--update writes them. Look at the pictures before.
"""

import sys
from pathlib import Path

sys.path.append(str(Path(__file__).resolve().parents[1]))

import bpy
import numpy as np

from window import driver

ARGUMENTS = sys.argv[sys.argv.index("--") + 1 :]
FOLDER, UPDATES = Path(ARGUMENTS[0]), "--update" in ARGUMENTS
REFERENCES = Path(__file__).with_name("references")
BLOCK_PX = 10  # a pixel of a reference is the mean of a block
# Mean difference: two runs on one machine have 0.001, a missing character more than 0.02.
MOST_MEAN, MOST_CHANGED, CHANGED = 0.012, 0.03, 0.12
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


def add_sun():
    sun = bpy.data.objects.new("Sun", bpy.data.lights.new("Sun", "SUN"))
    sun.data.energy, sun.rotation_euler = 4.0, (0.9, 0.0, 0.4)
    bpy.context.scene.collection.objects.link(sun)


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


def heat_map(shown: bool):
    def step():
        bpy.context.window_manager.sinew_show_moved = shown

    return step


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
        compare(name, small(_pictures[name]))

    return step


def small(pixels: np.ndarray) -> np.ndarray:
    """A picture with one pixel per block."""
    rows, columns = pixels.shape[0] // BLOCK_PX, pixels.shape[1] // BLOCK_PX
    blocks = pixels[: rows * BLOCK_PX, : columns * BLOCK_PX].reshape(rows, BLOCK_PX, columns, BLOCK_PX, 3)
    return blocks.mean(axis=(1, 3))


def compare(name: str, pixels: np.ndarray):
    """Compares a small picture with its reference, or writes it."""
    path = REFERENCES / f"{name}.png"
    if UPDATES:
        driver.save(path, pixels)
        return
    reference = driver.load(path)
    assert reference.shape == pixels.shape, (name, reference.shape, pixels.shape)
    differences = np.abs(reference - pixels).max(axis=2)
    mean, changed = float(differences.mean()), float((differences > CHANGED).mean())
    print(f"{name}: mean difference {mean:.4f}, {100.0 * changed:.2f} % of the pixels changed", flush=True)
    assert mean < MOST_MEAN and changed < MOST_CHANGED, (name, mean, changed)


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
WAIT = driver.wait
SHADERS = [WAIT] * 25  # EEVEE compiles them while it draws
driver.run(
    [
        empty_file, driver.open_sidebar, WAIT, driver.open_tab, WAIT,
        state("1_empty", shows_no_muscles),
        example, WAIT, WAIT, state("2_first_muscles", shows_muscles),
        view("MUSCLES"), WAIT, state("3_muscles", shows_muscles),
        view("SKIN"), WAIT, state("4_skin", shows_no_muscles),
        view("XRAY"), bend, WAIT, state("5_bent_in_xray", differs_from("2_first_muscles", 0.005)),
        object_mode, choose, WAIT, state("6_handles", differs_from("5_bent_in_xray", 0.001)),
        heat_map(True), WAIT, state("7_heat_map", differs_from("6_handles", 0.001)),
        heat_map(False), shading("MATERIAL"), *SHADERS, state("8_material", shows_muscles),
        add_sun, shading("RENDERED"), *SHADERS, state("9_rendered", shows_muscles),
        shading("SOLID"), view("SKIN"), WAIT, state("10_bent_skin", differs_from("4_skin", 0.005)),
    ]
)  # fmt: skip
