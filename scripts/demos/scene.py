"""The demo inside Blender: adds muscles to a moving body, then measures, bakes, saves and renders it.

usage: scripts/run_in_blender.py scripts/demos/scene.py OUTPUT_DIR
"""

import sys
from pathlib import Path

import bpy
import numpy as np
from build.console import step
from data import body_in_blender

from demos import measures, motion
from demos import picture as demo_picture


def make_active(target) -> None:
    for other in bpy.context.selected_objects:
        other.select_set(False)
    target.select_set(True)
    bpy.context.view_layer.objects.active = target


def main(output: Path) -> None:
    with step("the body and its motion"):
        bpy.ops.wm.read_factory_settings(use_empty=True)
        skin, rig = body_in_blender.build()
        motion.animate(rig)
        armature_ms = measures.median_frame_ms(skin)
        armature_points = measures.points_by_frame(skin)

    with step("muscles, and the skin bound to them"):
        bpy.context.scene.frame_set(motion.FRAME_START)
        make_active(rig)
        bpy.ops.sinew.add_preset(name="limbs")
        muscles = measures.muscles_of(rig)
        motion.tense(muscles)
        make_active(skin)
        skin.sinew.skin.elastic = True
        bpy.ops.sinew.bind()

    with step("live measures"):
        live_ms = measures.median_frame_ms(skin)
        live_points = measures.points_by_frame(skin)
        drift = measures.largest_volume_drift(muscles)
        bpy.context.scene.frame_set(motion.PICTURE_FRAME)
        ellipsoids = [measures.ellipsoid_of(muscle) for muscle in muscles]

    with step("shape keys"):
        make_active(skin)
        bpy.ops.sinew.bake_shape_keys(
            frame_start=motion.FRAME_START, frame_end=motion.FRAME_END, step=1, tolerance=0.0, prefix="sinew_"
        )
        skin.sinew.skin.live = False
        baked_ms = measures.median_frame_ms(skin)
        baked_points = measures.points_by_frame(skin)

    with step("demo.blend"):
        bpy.context.scene.frame_set(motion.PICTURE_FRAME)
        bpy.ops.wm.save_as_mainfile(filepath=str(output / "demo.blend"), compress=True)

    pictured = measures.FRAMES.index(motion.PICTURE_FRAME)
    with step("demo.png"):
        demo_picture.render(
            output / "demo.png",
            faces=faces_of(skin),
            before=armature_points[pictured],
            after=live_points[pictured],
            ellipsoids=ellipsoids,
        )

    moved_mm = 1000.0 * np.linalg.norm(live_points - armature_points, axis=-1)
    apart_mm = 1000.0 * np.linalg.norm(live_points - baked_points, axis=-1)
    moved_count = int((moved_mm.max(axis=0) > 0.1).sum())
    print_table(
        {
            "vertices": f"{len(skin.data.vertices)}",
            "muscles": f"{len(muscles)}",
            "ms per frame, Armature modifier alone": f"{armature_ms:.2f} (median of frame_set)",
            "ms per frame, Sinew live": f"{live_ms:.2f}",
            "ms per frame, baked": f"{baked_ms:.2f}",
            "skin moved by Sinew": f"{moved_mm.max():.1f} mm at most; more than 0.1 mm at {moved_count} vertices",
            "belly volume drift": f"{drift:.1e} of the volume at most",
            "live against baked": f"{apart_mm.max():.1g} mm at most",
        }
    )


def faces_of(skin) -> list[tuple[int, ...]]:
    return [tuple(face.vertices) for face in skin.data.polygons]


def print_table(rows: dict[str, str]) -> None:
    width = max(map(len, rows))
    print("\n".join(f"{name:<{width}}  {value}" for name, value in rows.items()), flush=True)


if __name__ == "__main__":
    main(Path(sys.argv[1]))
