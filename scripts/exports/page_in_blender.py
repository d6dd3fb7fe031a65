"""The part of export_page.py inside Blender: exports the body, and compares the page with Blender.

usage: scripts/run_in_blender.py scripts/exports/page_in_blender.py export|compare correctives|frames DIR
"""

import json
import sys
from pathlib import Path

import bpy
import numpy as np
from demos import picture as demo_picture
from demos.motion import FRAME_END, FRAME_START, PICTURE_FRAME

from exports import exported
from exports import scene as export_scene

FRAMES = range(FRAME_START, FRAME_END + 1)
WIDTH, HEIGHT = 480, 760
CENTRE, SEEN_FROM, SHOWS_M = (0.0, 0.0, 0.92), (-0.3, -1.0, 0.08), 1.98
VIEW = {"centre": CENTRE, "seenFrom": SEEN_FROM, "shows": SHOWS_M, "width": WIDTH, "height": HEIGHT}  # for player.js
PANELS = tuple(
    demo_picture.Panel(
        caption,
        figure,
        figure * (WIDTH + demo_picture.GAP),
        0,
        WIDTH,
        HEIGHT,
        CENTRE,
        SEEN_FROM,
        SHOWS_M,
    )
    for figure, caption in enumerate(("Blender: live", "Blender: export copy"))
)


def export(keys: str, output: Path) -> None:
    skin, rig = export_scene.build(keys)
    scene = bpy.context.scene
    scene.frame_start, scene.frame_end = FRAME_START, FRAME_END
    copy = export_scene.copy_of(rig)
    live, shown = exported.shown(skin, FRAMES), exported.shown(copy, FRAMES)
    export_scene.hide_copy(rig)
    bpy.ops.wm.save_as_mainfile(filepath=str(output / "body.blend"), compress=True)
    bpy.ops.sinew.export(filepath=str(output / "body.glb"), format="GLTF")
    faces = [tuple(face.vertices) for face in skin.data.polygons]
    np.savez_compressed(output / "blender.npz", live=live, shown=shown)
    pictured = PICTURE_FRAME - FRAME_START
    demo_picture.render_figures(
        output / "blender.png", faces=faces, figures=[live[pictured], shown[pictured]], panels=PANELS
    )
    seconds = [(frame - FRAME_START) / scene.render.fps for frame in FRAMES]
    pictures = [{"file": "page.png", "seconds": seconds[pictured], "view": VIEW}]
    (output / "request.json").write_text(json.dumps({"times": seconds, "pictures": pictures}))


def compare(output: Path) -> None:
    with np.load(output / "blender.npz") as loaded:
        live, shown = loaded["live"], loaded["shown"]
    page = np.fromfile(output / "points.f32", np.float32).reshape(len(FRAMES), -1, 3)
    same = exported.same_vertices(page[0], shown[0])
    missing = len(shown[0]) - len(np.unique(same))
    print(f"vertices: {len(shown[0])} in Blender, {page.shape[1]} in the page, {missing} not found again")
    for name, points in (("Blender's export copy", shown), ("Blender's live skin", live)):
        apart_mm = 1000.0 * np.linalg.norm(page - points[:, same], axis=2)
        worst = int(apart_mm.max(axis=1).argmax())
        print(
            f"page from {name}, {len(FRAMES)} frames: {apart_mm.mean():.5f} mm on average, "
            f"{np.percentile(apart_mm, 99):.4f} at the 99th percentile, {apart_mm.max():.4f} at most (frame {FRAMES[worst]})"
        )
    join(output)


def join(output: Path) -> None:
    """player.png: Blender's live skin and export copy, and the page."""
    blender, page = (pixels_of(output / name) for name in ("blender.png", "page.png"))
    joined = np.concatenate((blender, np.ones((HEIGHT, demo_picture.GAP, 4), np.float32), page), axis=1)
    image = bpy.data.images.new("player", joined.shape[1], HEIGHT)
    image.pixels.foreach_set(joined.reshape(-1))
    image.filepath_raw, image.file_format = str(output / "player.png"), "PNG"
    image.save()


def pixels_of(file: Path) -> np.ndarray:
    """(height, width, 4) float32."""
    image = bpy.data.images.load(str(file))
    pixels = np.empty(image.size[0] * image.size[1] * 4, np.float32)
    image.pixels.foreach_get(pixels)
    return pixels.reshape(image.size[1], image.size[0], 4)


if __name__ == "__main__":
    what, keys, folder = sys.argv[1:]
    export(keys.upper(), Path(folder)) if what == "export" else compare(Path(folder))
