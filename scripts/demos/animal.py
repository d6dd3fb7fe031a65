"""Makes a moving animal: an armature, its muscles, a skin grown over them, a motion, a bake and a picture.

usage: scripts/run_in_blender.py scripts/demos/animal.py cat|dog|horse|toad|hand|human OUTPUT_DIR
"""

import statistics
import sys
import time
from pathlib import Path

import bpy
import numpy as np
from build.console import step

from demos import animals, walk
from demos.animal_picture import Figure, render
from demos.measures import ellipsoid_of, points_of
from demos.scene import faces_of, make_active, print_table

SHOWN_KINDS = ("MUSCLE", "BONE", "STUFFING")


def main(animal: str, output: Path) -> None:
    with step("armature, muscles and skin"):
        start_s = time.perf_counter()
        rig, skin = animals.grow(animal)
        grown_s = time.perf_counter() - start_s
        tissues = [found for found in bpy.data.objects if found.parent == rig and found.type == "EMPTY"]
        shown = [found for found in tissues if found.sinew.tissue.kind in SHOWN_KINDS]
        anatomy = [(found.sinew.tissue.kind, ellipsoid_of(found)) for found in shown]
        rest = points_of(skin)
        slots = np.empty(len(skin.data.polygons), np.int32)
        skin.data.polygons.foreach_get("material_index", slots)

    with step("the motion"):
        walk.animate(rig, animal)
        times = []
        for frame in range(walk.FRAME_START, walk.FRAME_END + 1):
            start_s = time.perf_counter()
            bpy.context.scene.frame_set(frame)
            times.append(time.perf_counter() - start_s)
        bpy.context.scene.frame_set(walk.PICTURE_FRAME)
        walking = points_of(skin)

    with step("shape keys"):
        make_active(skin)
        bpy.ops.sinew.bake_shape_keys(frame_start=walk.FRAME_START, frame_end=walk.FRAME_END)

    with step(f"{animal}.blend"):
        bpy.ops.wm.save_as_mainfile(filepath=str(output / f"{animal}.blend"), compress=True)

    with step(f"{animal}.png"):
        figure = Figure(faces_of(skin), rest, walking, anatomy, list(skin.data.materials), slots)
        render(output / f"{animal}.png", animal, figure)

    print_table(
        {
            "tissues": f"{len(tissues)}",
            "skin": f"{len(skin.data.vertices)} vertices, {len(skin.data.polygons)} faces",
            "muscles, skin, UVs and bind in": f"{grown_s:.2f} s",
            "ms per frame, live": f"{1000.0 * statistics.median(times):.2f} (median of frame_set)",
            "live against baked": f"{skin.sinew.skin.bake_error_mm:.4f} mm at most",
            "moves by": f"{1000.0 * np.linalg.norm(walking - rest, axis=1).max():.0f} mm at most",
        }
    )


if __name__ == "__main__":
    main(sys.argv[1], Path(sys.argv[2]))
