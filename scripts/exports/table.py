"""Measures what glTF, FBX, USD and Alembic keep of a baked body: exports it, imports it without Sinew, compares.

usage: python3 scripts/run_in_blender.py [--blender 5.2|4.5] scripts/exports/table.py
           [--keys correctives|frames|none] [--influences 4|8]

The body is the demo's, with baked keys and muscle bones over the demo's 48 frames. Each file is imported into an empty file
in another process with factory settings. Distances are those of the posed points from the export copy in Blender, and from
live.
"""

import argparse
import tempfile
from pathlib import Path

import bpy
import numpy as np
from demos.motion import FRAME_END, FRAME_START

from exports import exported
from exports import scene as export_scene

FRAMES = range(FRAME_START, FRAME_END + 1)


def main() -> None:
    parser = argparse.ArgumentParser(description="Measures what glTF, FBX, USD and Alembic keep of a baked body.")
    parser.add_argument("--keys", choices=[keys.lower() for keys in export_scene.KEYS], default="correctives")
    parser.add_argument("--influences", choices=["4", "8"], default="4", help="most bones per vertex")
    wanted = parser.parse_args()
    skin, rig = export_scene.build(wanted.keys.upper(), wanted.influences)
    bpy.context.scene.frame_start, bpy.context.scene.frame_end = FRAME_START, FRAME_END
    copy = export_scene.copy_of(rig)
    live, shown = exported.shown(skin, FRAMES), exported.shown(copy, FRAMES)
    export_scene.hide_copy(rig)
    bare = shown_by_armature_alone(skin)
    print(f"Armature modifier alone from live: {distances_text(bare, live)}")
    print(f"export copy from live: {distances_text(shown, live)}")
    print("| format | from Blender's: mean, max | from live: mean, max | keys, curves | bones, of muscles, curves | MB |")
    with tempfile.TemporaryDirectory() as folder:
        for name, suffix in exported.SUFFIXES.items():
            path = Path(folder, f"body{suffix}")
            bpy.ops.sinew.export(filepath=str(path), format=name, influences=wanted.influences)
            back, from_live = exported.round_trips([(path, shown, None), (path, live, None)], FRAME_START)
            contents = back.contents
            print(
                f"| {name} | {back.mean_mm:.5f}, {back.max_mm:.4f} mm | {from_live.mean_mm:.3f}, {from_live.max_mm:.2f} mm "
                f"| {contents['keys']}, {contents['key curves']} | {contents['bones']}, {contents['muscle bones']}, "
                f"{contents['bone curves']} "
                f"| {path.stat().st_size / 1e6:.1f} |",
                flush=True,
            )


def shown_by_armature_alone(skin) -> np.ndarray:
    modifier = next(modifier for modifier in skin.modifiers if modifier.type == "NODES")
    modifier.show_viewport = False
    points = exported.shown(skin, FRAMES)
    modifier.show_viewport = True
    return points


def distances_text(points: np.ndarray, others: np.ndarray) -> str:
    distances_mm = 1000.0 * np.linalg.norm(points - others, axis=2)
    return f"{distances_mm.mean():.3f}, {distances_mm.max():.2f} mm"


if __name__ == "__main__":
    main()
