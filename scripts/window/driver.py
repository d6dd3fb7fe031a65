"""Drives a Blender with a window: steps on a timer, mouse and keyboard by xdotool, pictures by ImageMagick.

Blender's own screenshot is black on a virtual screen, so `import` takes the picture of the X screen.
"""

import os
import subprocess
import sys
import time
import traceback
from collections.abc import Callable
from pathlib import Path

import bpy
import numpy as np
from bpy_extras.view3d_utils import location_3d_to_region_2d
from mathutils import Vector

FIRST_S, BETWEEN_STEPS_S = 2.0, 1.2
PAUSE_S = 0.15  # between two events
_failures: list[str] = []


def run(steps: list[Callable]) -> None:
    """Runs the steps and ends Blender, with exit code 1 if one of them failed."""
    remaining = list(steps)

    def step():
        try:
            remaining.pop(0)()
        except Exception:
            _failures.append(traceback.format_exc())
        if remaining:
            return BETWEEN_STEPS_S
        for failure in _failures:
            print(failure, file=sys.stderr)
        print(f"{len(_failures)} of {len(steps)} steps failed", flush=True)
        sys.stderr.flush()
        os._exit(1 if _failures else 0)  # quit_blender has no exit code

    bpy.context.preferences.view.show_splash = False
    bpy.app.timers.register(step, first_interval=FIRST_S, persistent=True)


def parts():
    """(window, area, region) of the 3D viewport."""
    window = bpy.context.window_manager.windows[0]
    area = next(area for area in window.screen.areas if area.type == "VIEW_3D")
    return window, area, next(region for region in area.regions if region.type == "WINDOW")


def in_viewport():
    """A context in which operators run in the 3D viewport."""
    window, area, region = parts()
    return bpy.context.temp_override(window=window, area=area, region=region)


def open_sidebar() -> None:
    with in_viewport():
        parts()[1].spaces.active.show_region_ui = True


def open_tab() -> None:
    next(region for region in parts()[1].regions if region.type == "UI").active_panel_category = "Sinew"


def wait() -> None:
    """A step that only lets Blender draw."""


def picture(path: Path) -> np.ndarray:
    """Saves a picture of the screen. Returns the 3D viewport without its sidebar, (height, width, 3) float32, 0..1."""
    subprocess.run(["import", "-window", "root", str(path)], check=True)
    _window, area, region = parts()
    sidebar = next(found.width for found in area.regions if found.type == "UI")
    rows = slice(region.y, region.y + region.height)
    return load(path)[rows, region.x : region.x + region.width - sidebar]


def save(path: Path, pixels: np.ndarray) -> None:
    """Writes (height, width, 3) numbers 0..1, from the bottom row up, as a PNG."""
    height, width, _channels = pixels.shape
    image = bpy.data.images.new(path.stem, width, height)
    image.pixels.foreach_set(np.concatenate((pixels, np.ones((height, width, 1))), axis=2).astype(np.float32).reshape(-1))
    image.filepath_raw, image.file_format = str(path), "PNG"
    image.save()
    bpy.data.images.remove(image)


def load(path: Path) -> np.ndarray:
    """Reads what `save` wrote, as (height, width, 3) float32."""
    image = bpy.data.images.load(str(path))
    width, height = image.size
    pixels = np.empty(width * height * 4, np.float32)
    image.pixels.foreach_get(pixels)
    bpy.data.images.remove(image)
    return pixels.reshape(height, width, 4)[..., :3]


def crop(path: Path, part: str, size: str) -> None:
    """Saves a part of the screen as a PNG of 256 colors. part, size: as ImageMagick writes them."""
    subprocess.run(["import", "-window", "root", str(path)], check=True)
    subprocess.run(
        ["convert", str(path), "-crop", part, "+repage", "-resize", size, "-colors", "255", f"PNG8:{path}"], check=True
    )


def pixel_of(point: Vector) -> tuple[int, int]:
    """The position on the screen of a point in world space."""
    window, area, region = parts()
    at = location_3d_to_region_2d(region, area.spaces.active.region_3d, point)
    return round(region.x + at.x), round(window.height - (region.y + at.y))


def xdotool(*words) -> None:
    subprocess.run(["xdotool", *map(str, words)], check=True)
    time.sleep(PAUSE_S)


def focus() -> None:
    """Gives Blender's window the keyboard: a virtual screen has no window manager."""
    found = subprocess.run(["xdotool", "search", "--onlyvisible", "--name", "Blender"], capture_output=True, text=True)
    xdotool("windowfocus", found.stdout.split()[0])


def move(position: tuple[int, int]) -> None:
    """Moves the mouse to a position on the screen, by way of the next pixel, so that Blender notices it."""
    xdotool("mousemove", position[0] - 2, position[1])
    xdotool("mousemove", *position)


def click(position: tuple[int, int]) -> None:
    move(position)
    xdotool("mousedown", 1)
    xdotool("mouseup", 1)
