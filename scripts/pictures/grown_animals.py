"""Renders turntables of the grown animals for docs/: above the muscles without the skin, below the skin grown over them.

usage: python3 scripts/run_in_blender.py scripts/pictures/grown_animals.py [ANIMAL...] [--out FOLDER] [--width 380]
"""

import argparse
import tempfile
from pathlib import Path

import bpy
import numpy as np
from bl_ext.user_default.sinew.scene import characters, tissue_empty
from build.layout import ROOT
from demos.animals import ANIMALS, grow
from mathutils import Matrix, Vector

from pictures.anatomy import draw, render

PUBLISHED = ("cat", "dog", "horse", "toad", "hand")
# Directions to the camera: left, back, up.
TURNTABLE = ((1, -0.12, 0.1), (0.75, -1, 0.35), (0, -1, 0.12), (-0.8, -0.7, 0.25), (0.7, 1, 0.35))
HAND_TURNTABLE = ((1, 0.1, 0.1), (0.5, -1, 0.3), (0.1, -0.5, 1), (0.2, -0.5, -1), (-1, -0.3, 0.2))
MARGIN = 1.08
SHAPE = 0.72  # height over width of one view
SIZE_M = 1.0  # what is shown is scaled to this, because the renderer's camera is 3 m away
# What a view is centred on and how much of it, where not the whole: the lowest and highest corner in metres.
CROPPED = {
    "cat": ((-0.12, -0.29, 0.0), (0.12, 0.26, 0.3)),
    "dog": ((-0.25, -0.88, 0.0), (0.25, 0.72, 1.05)),
    "hand": ((0.06, -0.16, -0.22), (0.22, 0.08, 0.06)),
}


def shown(name: str):
    """The tissues and the skin of an animal in rest pose."""
    rig, skin = grow(name)
    shapes = [tissue_empty.read(empty, rig) for empty in characters.tissues_of(rig)]
    materials = list(skin.data.materials)
    skin.parent = None
    skin.matrix_world = Matrix()
    skin.modifiers.clear()
    slots = np.empty(len(skin.data.polygons), np.int32)
    skin.data.polygons.foreach_get("material_index", slots)
    return shapes, skin, materials, slots


def turntable(name: str, folder: Path, width: int) -> Path:
    shapes, skin, materials, slots = shown(name)
    points = np.array([vertex.co for vertex in skin.data.vertices])
    low, high = (np.array(corner) for corner in CROPPED.get(name, (points.min(0), points.max(0))))
    points = points[((points >= low) & (points <= high)).all(1)]
    scale = SIZE_M / (high - low).max()
    draw(shapes, skin)
    to_picture = Matrix.Scale(scale, 4)
    for found in bpy.context.scene.objects:
        found.matrix_world = to_picture @ found.matrix_world
    tissues = [found for found in bpy.context.scene.objects if found != skin]
    skin.data.materials.clear()
    for material in materials or [_plain(ANIMALS[name].coat)]:
        skin.data.materials.append(material)
    skin.data.polygons.foreach_set("material_index", slots)
    rows = []
    for with_skin in (False, True):
        skin.hide_render = not with_skin
        for found in tissues:
            found.hide_render = with_skin
        rows.append([_view(view, points * scale, width) for view in _views(name)])
    sheet = np.vstack([np.hstack(row) for row in rows[::-1]])
    return _save(sheet, folder / f"animal_{name}.png")


def _views(name: str):
    return HAND_TURNTABLE if name == "hand" else TURNTABLE


def _view(view: tuple, points: np.ndarray, width: int) -> np.ndarray:
    """(height, width, 4) float32: one view that these points fill, with the first row at the bottom."""
    direction = Vector(view).normalized()
    side = Vector((0, 0, 1)).cross(direction).normalized()
    up = direction.cross(side)
    middle, sizes = Vector(), []
    for axis in (side, up, direction):
        along = points @ np.array(axis)
        middle += axis * float(along.min() + along.max()) / 2
        sizes.append(float(np.ptp(along)))
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "view.png")
        render(direction, middle, MARGIN * max(sizes[0], sizes[1] / SHAPE), (width, int(width * SHAPE)), path)
        image = bpy.data.images.load(str(path))
        pixels = np.array(image.pixels[:], np.float32).reshape(image.size[1], image.size[0], 4)
        bpy.data.images.remove(image)
    for found in list(bpy.context.scene.objects):
        if found.type in ("CAMERA", "LIGHT"):
            bpy.data.objects.remove(found)
    return pixels


def _plain(colour):
    material = bpy.data.materials.new("Coat")
    material.diffuse_color = colour
    shader = next(node for node in material.node_tree.nodes if node.type == "BSDF_PRINCIPLED")
    shader.inputs["Base Color"].default_value = colour
    return material


def _save(pixels: np.ndarray, path: Path) -> Path:
    image = bpy.data.images.new("Sheet", pixels.shape[1], pixels.shape[0])
    image.pixels = pixels.ravel()
    image.filepath_raw, image.file_format = str(path), "PNG"
    image.save()
    return path


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("animals", nargs="*", metavar="ANIMAL", default=PUBLISHED)
    parser.add_argument("--out", type=Path, default=ROOT / "docs")
    parser.add_argument("--width", type=int, default=380, help="pixels of one view")
    wanted = parser.parse_args()
    wanted.out.mkdir(parents=True, exist_ok=True)
    for name in wanted.animals:
        path = turntable(name, wanted.out, wanted.width)
        print(f"{path}: {path.stat().st_size // 1000} kB", flush=True)


if __name__ == "__main__":
    main()
