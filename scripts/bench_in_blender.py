"""The timing inside Blender: one character, all limbs bending in every frame, each deformer in turn.

usage: scripts/run_in_blender.py scripts/bench_in_blender.py PRESET VERTICES MUSCLES ITERATIONS ROUNDS

A frame is `frame_set` with all that hangs on it: the pose, the modifiers, Sinew's handler, and Blender's second
evaluation of the mesh that the handler wrote to. No frame is at rest.
"""

import math
import statistics
import sys
import time
from dataclasses import dataclass, field

import body_in_blender
import bpy
import dense_body
import demo_motion
from bl_ext.user_default.sinew import evaluate
from console import step
from demo_measures import muscles_of
from demo_scene import make_active

FIRST, LAST = 1, 24
# degrees at the first and the last frame, all far from rest
BENT = {
    f"{joint}.{side}": angles
    for side in "LR"
    for joint, angles in (("shoulder", (55, 110)), ("elbow", (70, 140)), ("hip", (20, 100)), ("knee", (30, 130)))
}
ARMATURE, SMOOTH = "Armature modifier", "Armature + Corrective Smooth"
SINEW, SINEW_SHOWN = "Sinew, elastic, muscles hidden", "Sinew, elastic, muscles shown"
MODES = (ARMATURE, SMOOTH, SINEW, SINEW_SHOWN)


@dataclass
class Clock:
    """Milliseconds of a function's calls, measured around it."""

    calls_ms: list[float] = field(default_factory=list)

    def around(self, function):
        def timed(*arguments, **named):
            start = time.perf_counter()
            try:
                return function(*arguments, **named)
            finally:
                self.calls_ms.append(1000.0 * (time.perf_counter() - start))

        return timed

    def taken_ms(self) -> float:
        """The milliseconds since it was asked last."""
        total = sum(self.calls_ms)
        self.calls_ms.clear()
        return total


def animate(rig) -> None:
    """Bends all limbs, a little further in every frame."""
    bpy.context.scene.frame_start, bpy.context.scene.frame_end = FIRST, LAST
    for joint, angles in BENT.items():
        hinge = demo_motion.hinge(rig, joint)
        bone = rig.pose.bones[hinge.bone]
        own = bone.bone.matrix_local.to_3x3()
        bone.rotation_mode = "QUATERNION"
        for frame, degrees in zip((FIRST, LAST), angles, strict=True):
            bone.rotation_quaternion = (own.inverted() @ hinge.turn(math.radians(degrees)) @ own).to_quaternion()
            bone.keyframe_insert("rotation_quaternion", frame=frame)


def add_muscles(rig, preset: str, most: int) -> int:
    """Adds a preset and keeps its largest muscles, all tissues that are none too; returns how many."""
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


def switch(skin, rig, smooth, mode: str) -> None:
    smooth.show_viewport = mode == SMOOTH
    skin.sinew.live = mode in (SINEW, SINEW_SHOWN)
    rig.sinew.show_empties = mode == SINEW_SHOWN
    bpy.context.scene.frame_set(FIRST)
    bpy.context.view_layer.update()


def play(frame_clock: Clock, handler: Clock, correct: Clock, found: dict) -> None:
    """Plays all frames once and adds what each took, ms."""
    handler.taken_ms(), correct.taken_ms()
    for frame in range(FIRST + 1, LAST + 1):
        frame_clock.around(bpy.context.scene.frame_set)(frame)
        for name, clock in (("frame", frame_clock), ("handler", handler), ("correct", correct)):
            found.setdefault(name, []).append(clock.taken_ms())


def report(times: dict[str, dict[str, list[float]]]) -> None:
    median = {mode: {name: statistics.median(of) for name, of in found.items()} for mode, found in times.items()}
    smooth_ms, armature_ms = median[SMOOTH]["frame"], median[ARMATURE]["frame"]
    print(f"\n{'median of a frame':<34}{'ms':>8}{'of Corrective Smooth':>24}")
    for mode in MODES:
        print(f"{mode:<34}{median[mode]['frame']:>8.2f}{median[mode]['frame'] / smooth_ms:>23.2f}x")
    print(f"\n{'where the time goes, ms':<34}{'Rust':>8}{'Python':>10}{'Armature':>10}{'second evaluation':>19}")
    for mode in (SINEW, SINEW_SHOWN):
        found = median[mode]
        rest = found["frame"] - found["handler"] - armature_ms
        print(
            f"{mode:<34}{found['correct']:>8.2f}{found['handler'] - found['correct']:>10.2f}{armature_ms:>10.2f}{rest:>19.2f}"
        )


def main(preset: str, vertices: int, most_muscles: int, iterations: int, rounds: int) -> None:
    with step("the character"):
        bpy.ops.wm.read_factory_settings(use_empty=True)
        skin, rig = body_in_blender.build()
        dense_body.subdivide(skin.data, vertices)
        smooth = add_smooth(skin, iterations)
        count = add_muscles(rig, preset, most_muscles)
        make_active(skin)
        skin.sinew.elastic, skin.sinew.iterations = True, iterations
        bpy.ops.sinew.bind()
        animate(rig)
    handler, correct = Clock(), Clock()
    evaluate.frame, evaluate.correct = handler.around(evaluate.frame), correct.around(evaluate.correct)
    times: dict[str, dict[str, list[float]]] = {mode: {} for mode in MODES}
    with step(f"{rounds} rounds of {LAST - FIRST} frames of each"):
        for _ in range(rounds):
            for mode in MODES:
                switch(skin, rig, smooth, mode)
                play(Clock(), handler, correct, times[mode])
    print(f"{len(skin.data.vertices)} vertices, {count} muscles of '{preset}', {iterations} iterations, bpy {bpy.app.version_string}")
    report(times)


if __name__ == "__main__":
    main(sys.argv[1], *map(int, sys.argv[2:]))
