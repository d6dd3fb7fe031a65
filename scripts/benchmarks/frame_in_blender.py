"""Measures the time of a frame in Blender: one character, all limbs bending in every frame, each deformer in turn.

usage: scripts/run_in_blender.py scripts/benchmarks/frame_in_blender.py PRESET VERTICES MUSCLES ITERATIONS ROUNDS

A frame is `frame_set` and everything that it causes: the pose and the modifiers, and Sinew's handlers before and after them.
No frame is at rest. Blender's own deformers are measured without Sinew's handlers, and with Sinew's muscles excluded from
the view layer.
"""

import math
import statistics
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager

import bpy
from bl_ext.user_default.sinew.live import frame as live_frame
from bl_ext.user_default.sinew.live import handlers
from bl_ext.user_default.sinew.scene import scout, tissue_collection
from build.console import step
from data import body_in_blender, dense_body
from demos import motion
from demos.measures import muscles_of
from demos.scene import make_active

FIRST, LAST = 1, 24
# degrees in the first and the last frame, all far from rest
BENT = {
    f"{joint}.{side}": angles
    for side in "LR"
    for joint, angles in (("shoulder", (55, 110)), ("elbow", (70, 140)), ("hip", (20, 100)), ("knee", (30, 130)))
}
ARMATURE, SMOOTH = "Armature modifier", "Armature + Corrective Smooth"
SINEW, SINEW_SHOWN = "Sinew, elastic, muscles hidden", "Sinew, elastic, muscles shown"
ANCHORS = "Sinew, not elastic"
MODES = (ARMATURE, SMOOTH, SINEW, SINEW_SHOWN, ANCHORS)
FIRST_PLAYS_MS: list[float] = []  # a frame, when the safeguard samples the rotations
PARTS = ("Blender", "scout", "Rust", "Python")
HANDLER_LISTS = ("frame_change_pre", "frame_change_post")


class Clock:
    """Measures the parts of a frame: Sinew's Rust, its scout, the rest of its handlers, and what remains to Blender."""

    def __init__(self):
        self.times_ms: dict[str, dict[str, list[float]]] = {mode: {} for mode in MODES}
        self._seconds: dict[str, float] = {}
        live_frame.correct = self._timed("Rust", live_frame.correct)
        scout.Scout.evaluate = self._timed("scout", scout.Scout.evaluate)

    def _timed(self, name: str, function):
        def timed(*arguments):
            start = time.perf_counter()
            try:
                return function(*arguments)
            finally:
                self._seconds[name] = self._seconds.get(name, 0.0) + time.perf_counter() - start

        return timed

    @contextmanager
    def around_handlers(self) -> Iterator[None]:
        """Replaces the handlers by timed ones. Beside a second handler, Sinew would check more for edits."""
        lists = [getattr(bpy.app.handlers, name) for name in HANDLER_LISTS]
        before = [list(called) for called in lists]
        for called in lists:
            called[:] = [self._timed("handlers", handler) for handler in called]
        yield
        for called, registered in zip(lists, before, strict=True):
            called[:] = registered

    def frame(self, mode: str, frame: int):
        """Shows a frame and keeps its times."""
        self._seconds.clear()
        start = time.perf_counter()
        bpy.context.scene.frame_set(frame)
        whole = time.perf_counter() - start
        handlers_s, scout_s, rust_s = (self._seconds.get(name, 0.0) for name in ("handlers", "scout", "Rust"))
        parts = (whole - handlers_s, scout_s, rust_s, handlers_s - scout_s - rust_s)
        for name, seconds in (("frame", whole), *zip(PARTS, parts, strict=True)):
            self.times_ms[mode].setdefault(name, []).append(1000.0 * seconds)


def animate(rig) -> None:
    """Bends all limbs, a little further in every frame."""
    bpy.context.scene.frame_start, bpy.context.scene.frame_end = FIRST, LAST
    for joint, angles in BENT.items():
        hinge = motion.hinge(rig, joint)
        bone = rig.pose.bones[hinge.bone]
        rest = bone.bone.matrix_local.to_3x3()
        bone.rotation_mode = "QUATERNION"
        for frame, degrees in zip((FIRST, LAST), angles, strict=True):
            bone.rotation_quaternion = (rest.inverted() @ hinge.turn(math.radians(degrees)) @ rest).to_quaternion()
            bone.keyframe_insert("rotation_quaternion", frame=frame)


def add_muscles(rig, preset: str, most: int) -> int:
    """Adds a preset, keeps its largest muscles and all its other tissues, and returns the number of muscles."""
    make_active(rig)
    bpy.ops.sinew.add_preset(name=preset)
    muscles = sorted(muscles_of(rig), key=lambda muscle: math.prod(muscle.scale), reverse=True)
    for muscle in muscles[most:] if most else ():
        bpy.data.objects.remove(muscle)
    return len(muscles_of(rig))


def add_smooth(skin, iterations: int):
    """A Corrective Smooth modifier bound in the rest pose."""
    smooth = skin.modifiers.new("Smooth", "CORRECTIVE_SMOOTH")
    smooth.iterations, smooth.rest_source = iterations, "BIND"
    with bpy.context.temp_override(object=skin, active_object=skin):
        bpy.ops.object.correctivesmooth_bind(modifier=smooth.name)
    bpy.context.view_layer.update()
    if not smooth.is_bind:
        raise SystemExit("Corrective Smooth was not bound")
    return smooth


@contextmanager
def deformed_by(skin, rig, smooth, mode: str) -> Iterator[None]:
    """Lets one deformer act alone, at the first frame. Sinew's handlers are registered for Sinew only."""
    is_sinew = mode in (SINEW, SINEW_SHOWN, ANCHORS)
    smooth.show_viewport = mode == SMOOTH
    skin.sinew.skin.live = is_sinew
    skin.sinew.skin.viewport_detail = "ANCHORS" if mode == ANCHORS else "FULL"
    rig.sinew.rig.show_empties = mode == SINEW_SHOWN
    bpy.context.view_layer.layer_collection.children[tissue_collection.collection_of(rig).name].exclude = not is_sinew
    if is_sinew:
        handlers.register()
    bpy.context.scene.frame_set(FIRST)
    bpy.context.view_layer.update()
    if is_sinew:
        play_once()
    yield
    if is_sinew:
        handlers.unregister()


def play_once() -> None:
    """Plays all frames, so that the safeguard has sampled the rotations in them. It samples each once in a session."""
    start = time.perf_counter()
    for frame in range(FIRST, LAST + 1):
        bpy.context.scene.frame_set(frame)
    FIRST_PLAYS_MS.append(1e3 * (time.perf_counter() - start) / (LAST - FIRST + 1))
    bpy.context.scene.frame_set(FIRST)


def report(times_ms: dict[str, dict[str, list[float]]]) -> None:
    median = {mode: {name: statistics.median(of) for name, of in found.items()} for mode, found in times_ms.items()}
    least = {mode: {name: min(of) for name, of in found.items()} for mode, found in times_ms.items()}
    print(f"\n{'a frame, ms':<34}{'median':>8}{'of Corrective Smooth':>22}{'least':>8}{'of Corrective Smooth':>22}")
    for mode in MODES:
        row = "".join(
            f"{of[mode]['frame']:>8.2f}{of[mode]['frame'] / of[SMOOTH]['frame']:>21.2f}x" for of in (median, least)
        )
        print(f"{mode:<34}{row}")
    print(f"\n{'parts, ms: median (least)':<34}" + "".join(f"{part:>20}" for part in PARTS))
    for mode in MODES:
        row = "".join(f"{f'{median[mode][part]:.2f} ({least[mode][part]:.2f})':>20}" for part in PARTS)
        print(f"{mode:<34}{row}")


def main(preset: str, vertices: int, most_muscles: int, iterations: int, rounds: int) -> None:
    with step("the character"):
        bpy.ops.wm.read_factory_settings(use_empty=True)
        skin, rig = body_in_blender.build()
        dense_body.subdivide(skin.data, vertices)
        smooth = add_smooth(skin, iterations)
        count = add_muscles(rig, preset, most_muscles)
        make_active(skin)
        skin.sinew.skin.elastic, skin.sinew.skin.iterations = True, iterations
        bpy.ops.sinew.bind()
        animate(rig)
    handlers.unregister()
    clock = Clock()
    with step(f"{rounds} rounds of {LAST - FIRST} frames of each"):
        for _ in range(rounds):
            for mode in MODES:
                with deformed_by(skin, rig, smooth, mode), clock.around_handlers():
                    for frame in range(FIRST + 1, LAST + 1):
                        clock.frame(mode, frame)
    of = f"{len(skin.data.vertices)} vertices, {count} muscles of '{preset}', {iterations} iterations"
    print(f"{of}, bpy {bpy.app.version_string}")
    report(clock.times_ms)
    print(f"\nplayed for the first time after the bind: {statistics.median(FIRST_PLAYS_MS):.2f} ms a frame")


if __name__ == "__main__":
    main(sys.argv[1], *map(int, sys.argv[2:]))
