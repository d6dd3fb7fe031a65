"""Measures bakes of the real body: number of keys, distance from the live skin, and time.

usage: python3 scripts/run_in_blender.py scripts/benchmarks/bake_table.py [--tolerances MM ...] [--most-keys N]

The body has the `limbs` preset and default settings. The first table bakes 250 frames of the demo's motion. The second table
bakes the correctives of each joint by itself. It poses the rig in steps of 1 degree between the sampled angles and compares
the skin of the keys with the live skin, both as Blender evaluates them. The last line is the time to write one key on a body
of 30,000 vertices.
"""

import argparse
import math
import time

import bpy
import numpy as np
from bl_ext.user_default.sinew.bake.correctives import corrective_drivers, turn_ranges
from bl_ext.user_default.sinew.bake.keys import key_store
from bl_ext.user_default.sinew.bake.scratch import joint_turns
from bl_ext.user_default.sinew.scene import mesh_arrays
from data import body_in_blender, dense_body
from demos import motion as demo_motion

JOINTS = (
    ("elbow to 90°", "lowerarm01.L", "0..90"),
    ("elbow to 150°", "lowerarm01.L", "0..150"),
    ("knee to 90°", "lowerleg01.L", "0..90"),
    ("knee to 140°", "lowerleg01.L", "0..140"),
    ("hip, two axes ±60°, twist ±45°", "upperleg01.L", "X -60..60 Y -45..45 Z -60..60"),
    ("shoulder, two axes ±90°, twist ±60°", "upperarm01.L", "X -90..90 Y -60..60 Z -90..90"),
)
FRAMES = 250
OFF_SAMPLES_DEGREES = 0.4
VERTICES = 30_000


def bound_body():
    """The body with its muscles, bound and live."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    skin, rig = body_in_blender.build()
    bpy.ops.sinew.add_preset(name="limbs")
    bind(skin)
    return skin, rig


def bind(skin) -> None:
    for found in bpy.context.view_layer.objects:
        found.select_set(found == skin)
    bpy.context.view_layer.objects.active = skin
    bpy.ops.sinew.bind()


def points(skin, live: bool) -> np.ndarray:
    skin.sinew.skin.live = live
    bpy.context.view_layer.update()
    return mesh_arrays.read_evaluated_points(skin.evaluated_get(bpy.context.evaluated_depsgraph_get()).data)


def measured_mm(skin, rig, bone: str, angles: str) -> float:
    """The largest distance from the live skin at angles between the samples.

    Where `angles` names no axis, the axis is the one in the names of the keys.
    """
    worst = 0.0
    posed = rig.pose.bones[bone]
    posed.rotation_mode = "QUATERNION"
    axes_of_keys = {baked.name.split(" ")[2][0] for baked in skin.sinew.skin.baked_keys}
    for axis, low, high in turn_ranges.parse_ranges(angles):
        axes = axis or axes_of_keys.pop()
        ends = (low, high) if axis else (low, high if _bends_up(skin) else -high)
        for degrees in np.arange(min(ends) + OFF_SAMPLES_DEGREES, max(ends), 1.0):
            turn = joint_turns.JointTurn(bone, axes, tuple(joint_turns.AXES[axes]), -math.pi, math.pi)
            posed.rotation_quaternion = joint_turns.rotation_of([(turn, math.radians(degrees))])
            live, baked = points(skin, True), points(skin, False)
            worst = max(worst, 1000.0 * float(np.linalg.norm(live - baked, axis=1).max()))
    posed.rotation_quaternion.identity()
    return worst


def _bends_up(skin) -> bool:
    return float(skin.sinew.skin.baked_keys[-1].name.split(" ")[2][1:]) > 0.0


def print_frames(tolerances: list[float]) -> None:
    """Bakes the demo's motion, slowed down. The bake itself compares the baked and the live skin."""
    slower = (FRAMES - 1) / (demo_motion.FRAME_END - demo_motion.FRAME_START)
    poses = {1 + round((frame - 1) * slower): pose for frame, pose in demo_motion.KEY_POSES.items()}
    print(f"| {FRAMES} frames, tolerance | keys | live and baked differ by | time |\n|---|---|---|---|")
    skin, rig = bound_body()
    demo_motion.KEY_POSES = poses
    demo_motion.animate(rig)
    for tolerance in tolerances:
        began_s = time.perf_counter()
        bpy.ops.sinew.bake_shape_keys(frame_start=1, frame_end=FRAMES, tolerance=tolerance)
        took_s = time.perf_counter() - began_s
        keys = len(skin.sinew.skin.baked_keys)
        print(f"| {tolerance:g} mm | {keys} | {skin.sinew.skin.bake_error_mm:.3f} mm | {took_s:.1f} s |", flush=True)


def print_joints(tolerances: list[float], most_keys: int) -> None:
    skin, rig = bound_body()
    print(
        "| joint | tolerance | keys | at them | between, stated | between, measured | time |\n|---|---|---|---|---|---|---|"
    )
    for name, bone, angles in JOINTS:
        for tolerance in tolerances:
            points(skin, True)
            began_s = time.perf_counter()
            bpy.ops.sinew.bake_correctives(
                joints=bone, angles=angles, tolerance=tolerance, most_keys=most_keys, combinations=0
            )
            took_s = time.perf_counter() - began_s
            keys, at, between = _numbers_in(skin.sinew.skin.corrective_summary)
            measured = measured_mm(skin, rig, bone, angles)
            print(
                f"| {name} | {tolerance:g} mm | {keys} | {at} mm | {between} mm | {measured:.2f} mm | {took_s:.1f} s |",
                flush=True,
            )
            key_store.remove_baked(skin)


def _numbers_in(summary: str) -> tuple[str, str, str]:
    words = summary.split(": ")[1].split(" ")
    return words[0], words[2], words[6]


def print_time_per_key() -> None:
    bpy.ops.wm.read_factory_settings(use_empty=True)
    skin, rig = body_in_blender.build()
    dense_body.subdivide(skin.data, VERTICES)
    rest = mesh_arrays.read_points(skin.data)
    turn = joint_turns.JointTurn("lowerarm01.L", "X", tuple(joint_turns.AXES["X"]), 0.0, 2.0)
    times = []
    for key in range(60):
        began_s = time.perf_counter()
        made = key_store.add_key(skin, f"key {key}", rest)
        corrective_drivers.drive(made, rig, [corrective_drivers.TentWeight(turn, 0.0, 1.0, None)])
        times.append(1000.0 * (time.perf_counter() - began_s))
    name = f"a key of {len(rest):,} vertices with its driver"
    print(f"\n{name}: {np.median(times):.2f} ms, {max(times):.2f} at most, of {len(times)}")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--tolerances", type=float, nargs="+", default=[0.5, 0.1])
    parser.add_argument("--most-keys", type=int, default=0, help="most keys per axis; 0: no limit")
    wanted = parser.parse_args()
    print_frames(wanted.tolerances)
    print()
    print_joints(wanted.tolerances, wanted.most_keys)
    print_time_per_key()


if __name__ == "__main__":
    main()
