"""Measures how the time of a live frame grows, along one axis at a time.

usage: scripts/run_in_blender.py scripts/benchmarks/scaling_in_blender.py ROUNDS AXIS,AXIS,... [FILE.svg]

The frames are those of frame_in_blender.py: all limbs bend in every frame. Muscles are hidden.
"""

import os
import statistics
import sys
from dataclasses import dataclass, replace

import bpy
import _sinew
from bl_ext.user_default.sinew.live import handlers
from build.console import step
from data import body_in_blender, dense_body

from benchmarks import frame_in_blender as one

PRESET = "human"
CORES = os.cpu_count() or 1


@dataclass(frozen=True)
class Load:
    """What a frame has to compute."""

    vertices: int = 30_000
    muscles: int = 75
    iterations: int = 10
    threads: int = CORES
    characters: int = 1


LOADS = {
    "vertices": [Load(vertices=count) for count in (0, 30_000, 100_000)],  # 0: the body as it is
    "muscles": [Load(muscles=count) for count in (10, 37, 75, 0)],  # 0: all of the preset
    "iterations": [Load(iterations=count) for count in (3, 5, 10, 20)],
    "threads": [Load(threads=1 << power) for power in range(CORES.bit_length())],
    "characters": [Load(vertices=0, characters=count) for count in (1, 2, 5, 10)],
}
COLUMNS = ("frame", *one.PARTS)


def build(load: Load) -> Load:
    """Makes the characters. Returns the load with the real numbers of vertices and muscles."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    vertices = muscles = 0
    for _ in range(load.characters):
        skin, rig = body_in_blender.build()
        dense_body.subdivide(skin.data, load.vertices)
        muscles = one.add_muscles(rig, PRESET, load.muscles)
        one.make_active(skin)
        skin.sinew.skin.elastic, skin.sinew.skin.iterations = True, load.iterations
        bpy.ops.sinew.bind()
        rig.sinew.rig.show_empties = False
        one.animate(rig)
        vertices = len(skin.data.vertices)
    return replace(load, vertices=vertices, muscles=muscles)


def play(clock: one.Clock, mode: str, rounds: int) -> None:
    for _ in range(rounds):
        bpy.context.scene.frame_set(one.FIRST)
        with clock.around_handlers():
            for frame in range(one.FIRST + 1, one.LAST + 1):
                clock.frame(mode, frame)


def measure(clock: one.Clock, load: Load, rounds: int) -> tuple[Load, dict[str, float], float]:
    """The median times of the parts of a frame, and of a frame of the Armature modifiers alone, ms."""
    handlers.register()
    real = build(load)
    _sinew.set_thread_count(load.threads)
    for times_ms in clock.times_ms.values():
        times_ms.clear()
    one.play_once()
    play(clock, one.SINEW, rounds)
    skins = [found for found in bpy.data.objects if found.type == "MESH"]
    for skin in skins:
        skin.sinew.skin.live = False
    handlers.unregister()
    play(clock, one.ARMATURE, rounds)
    median = {name: statistics.median(clock.times_ms[one.SINEW][name]) for name in COLUMNS}
    return real, median, statistics.median(clock.times_ms[one.ARMATURE]["frame"])


def draw(rows: dict[str, list[tuple[int, float, float]]], path: str) -> None:
    """Draws the time of a frame and of its Rust part along each axis."""
    from matplotlib import pyplot

    drawing, axes = pyplot.subplots(1, len(rows), figsize=(3.2 * len(rows), 2.8), layout="constrained", squeeze=False)
    for axis, (name, found) in zip(axes[0], rows.items(), strict=True):
        counts, frame_ms, rust_ms = zip(*found, strict=True)
        axis.plot(counts, frame_ms, "o-", color="#2b6cb0", markersize=3, label="whole frame")
        axis.plot(counts, rust_ms, "o-", color="#dd6b20", markersize=3, label="Rust")
        axis.set(xlabel=name, ylim=(0, None))
        axis.spines[["top", "right"]].set_visible(False)
    axes[0][0].set_ylabel("ms")
    axes[0][0].legend(frameon=False, fontsize=8)
    drawing.savefig(path, metadata={"Date": None})


def main(rounds: int, names: list[str], plot: str) -> None:
    clock = one.Clock()
    rows: dict[str, list[tuple[int, float, float]]] = {}
    print(f"preset '{PRESET}', bpy {bpy.app.version_string}; medians, ms")
    for name in names:
        print(f"\n{name:>12}" + "".join(f"{column:>20}" for column in (*COLUMNS, "Armature alone")), flush=True)
        for load in LOADS[name]:
            with step(f"{name}: {getattr(load, name)}"):
                real, median, armature_ms = measure(clock, load, rounds)
            count = getattr(real, name)
            numbers = "".join(f"{median[column]:>20.2f}" for column in COLUMNS)
            print(f"{count:>12}{numbers}{armature_ms:>20.2f}", flush=True)
            rows.setdefault(name, []).append((count, median["frame"], median["Rust"]))
        others = replace(LOADS[name][-1], **{name: 0})
        fixed = {field: value for field, value in vars(others).items() if field != name}
        print("with " + ", ".join(f"{value or 'all'} {field}" for field, value in fixed.items()))
    if plot:
        draw(rows, plot)


if __name__ == "__main__":
    main(int(sys.argv[1]), sys.argv[2].split(","), sys.argv[3] if len(sys.argv) > 3 else "")
