# SPDX-License-Identifier: GPL-3.0-or-later
"""Draws a small picture of a rig's shaded muscles, as a thumbnail of a preset. Needs a window with a 3D viewport."""

from pathlib import Path

import bpy
import gpu
import numpy as np
from mathutils import Euler, Matrix, Vector

SIZE_PX = 128
_TURNED = Euler((1.40, 0.0, 0.45))  # from the front, a little from the side and from above
_MARGIN = 1.15  # for the radii of the outer muscles
_SMALLEST_M = 0.01
_DEPTH = 10.0  # of the picture's size
_SHADING = {"type": "SOLID", "light": "STUDIO", "color_type": "MATERIAL", "show_xray": False, "show_cavity": True}


def write(path: Path, shaded, context) -> bool:
    """Writes a picture of a rig's shaded muscles as a PNG. Returns False without a 3D viewport to draw it with."""
    found = _viewport(context)
    if found is None or not len(shaded.data.vertices):
        return False
    area, region = found
    space = area.spaces.active
    before = {name: getattr(space.shading, name) for name in _SHADING}
    overlays = space.overlay.show_overlays
    hidden = [other for other in context.view_layer.objects if other != shaded and not other.hide_get()]
    try:
        space.overlay.show_overlays = False
        for name, value in _SHADING.items():
            setattr(space.shading, name, value)
        for other in hidden:
            other.hide_set(True)
        context.view_layer.update()
        pixels = _draw(shaded, context, space, region)
    finally:
        for other in hidden:
            other.hide_set(False)
        for name, value in before.items():
            setattr(space.shading, name, value)
        space.overlay.show_overlays = overlays
    _save(path, pixels)
    return True


def _viewport(context):
    areas = context.window.screen.areas if context.window else ()
    for area in areas:
        if area.type == "VIEW_3D":
            return area, next(region for region in area.regions if region.type == "WINDOW")
    return None


def _draw(shaded, context, space, region) -> np.ndarray:
    """(SIZE_PX, SIZE_PX, 4) float32: the picture, from the bottom row up."""
    view, half = _camera(shaded)
    depth = _DEPTH * half
    projection = Matrix.Diagonal((1.0 / half, 1.0 / half, -1.0 / depth, 1.0))
    offscreen = gpu.types.GPUOffScreen(SIZE_PX, SIZE_PX)
    try:
        offscreen.draw_view3d(
            context.scene,
            context.view_layer,
            space,
            region,
            view,
            projection,
            do_color_management=True,
            draw_background=False,
        )
        buffer = offscreen.texture_color.read()
    finally:
        offscreen.free()
    buffer.dimensions = SIZE_PX * SIZE_PX * 4
    return np.array(buffer, np.float32).reshape(SIZE_PX, SIZE_PX, 4) / 255.0


def _camera(shaded) -> tuple[Matrix, float]:
    """(view matrix, half the size of what the picture shows) for the centres of the muscles, which are instances."""
    rotation = _TURNED.to_matrix()
    turned = [rotation.transposed() @ (shaded.matrix_world @ vertex.co) for vertex in shaded.data.vertices]
    low, high = (Vector(map(extreme, zip(*turned, strict=True))) for extreme in (min, max))
    centre, size = (low + high) / 2.0, high - low
    camera = Matrix.Translation(rotation @ centre) @ rotation.to_4x4()
    return camera.inverted(), _MARGIN * max(size.x, size.y, _SMALLEST_M) / 2.0


def _save(path: Path, pixels: np.ndarray):
    image = bpy.data.images.new(path.stem, SIZE_PX, SIZE_PX, alpha=True)
    try:
        image.pixels.foreach_set(np.ascontiguousarray(pixels).reshape(-1))
        image.filepath_raw, image.file_format = str(path), "PNG"
        image.save()
    finally:
        bpy.data.images.remove(image)
