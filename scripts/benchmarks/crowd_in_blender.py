"""Measures a frame of one character and of several, in turns: what a character costs in a crowd, at each level of detail.

usage: scripts/run_in_blender.py scripts/benchmarks/crowd_in_blender.py CHARACTERS ROUNDS [PRESET]

Each character is the body of 13,380 vertices with muscles of its own; all limbs bend in every frame. One character is
measured while the collection of the others is excluded from the view layer.
"""

import statistics
import sys
import time

import bpy
from bl_ext.user_default.sinew.settings import updates
from build.console import step
from data import body_in_blender
from demos.scene import make_active

from benchmarks import frame_in_blender

LEVELS = ("FULL", "ANCHORS", "ARMATURE")
ALONE = "Armature modifier, Sinew off"
SPACING_M = 2.0


def add_character(number: int, preset: str):
    """A body with muscles, bound and animated, beside the others. Returns its mesh object."""
    skin, rig = body_in_blender.build()
    rig.location.x = SPACING_M * number
    frame_in_blender.add_muscles(rig, preset, 0)
    rig.sinew.rig.show_empties = False
    make_active(skin)
    bpy.ops.sinew.bind()
    frame_in_blender.animate(rig)
    return skin


def gather_others(first: set) -> str:
    """Moves all objects but those of the first character to a collection of their own. Returns its name."""
    others = bpy.data.collections.new("Others")
    bpy.context.scene.collection.children.link(others)
    for found in set(bpy.data.objects) - first:
        for collection in list(found.users_collection):
            collection.objects.unlink(found)
        others.objects.link(found)
    return others.name


def play() -> list[float]:
    """The times of the frames, ms."""
    times_ms = []
    for frame in range(frame_in_blender.FIRST + 1, frame_in_blender.LAST + 1):
        start = time.perf_counter()
        bpy.context.scene.frame_set(frame)
        times_ms.append(1e3 * (time.perf_counter() - start))
    return times_ms


def main(count: int, rounds: int, preset: str) -> None:
    bpy.ops.wm.read_factory_settings(use_empty=True)
    with step(f"{count} characters"):
        skins = [add_character(0, preset)]
        first = set(bpy.data.objects)
        skins += [add_character(number, preset) for number in range(1, count)]
        others = bpy.context.view_layer.layer_collection.children[gather_others(first)]
    times_ms: dict[tuple[str, bool], list[float]] = {}
    for _round in range(rounds + 1):
        for level in (*LEVELS, ALONE):
            updates.set_enabled(level != ALONE)
            for skin in skins:
                skin.sinew.skin.viewport_detail = level if level in LEVELS else "FULL"
            for is_alone in (True, False):
                others.exclude = is_alone
                bpy.context.view_layer.update()
                play()  # binds, samples the safeguard and opens the scout
                times_ms.setdefault((level, is_alone), []).extend(play() if _round else [])
    print(f"\n{'a frame, ms: median (least)':<34}{'1 character':>18}{f'{count} characters':>18}{'ratio per character':>24}")
    for level in (*LEVELS, ALONE):
        one, all_of_them = times_ms[level, True], times_ms[level, False]
        medians, least = [[of(one), of(all_of_them)] for of in (statistics.median, min)]
        ratios = [some / one / count for one, some in (medians, least)]
        cells = [f"{median:.2f} ({shortest:.2f})" for median, shortest in zip(medians, least, strict=True)]
        print(f"{level:<34}{cells[0]:>18}{cells[1]:>18}{f'{ratios[0]:.2f} ({ratios[1]:.2f})':>24}")


if __name__ == "__main__":
    main(int(sys.argv[1]), int(sys.argv[2]), *(sys.argv[3:] or ["limbs"]))
