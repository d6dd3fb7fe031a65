"""The demo of reaching: goals for a hand and both feet, keyed, baked to 48 frames and rendered with a live skin.

usage: scripts/run_in_blender.py scripts/demos/reach.py OUTPUT_DIR

The left hand moves to the head and back, and the right foot onto a step. A goal holds the left foot while the body sinks.
"""

import sys
import time
from pathlib import Path

import bpy
import numpy as np
from build.console import step
from data import body_in_blender
from mathutils import Vector

from demos import measures
from demos import picture as demo_picture
from demos.motion import FRAME_END, FRAME_START, PICTURE_FRAME
from demos.picture import GAP, Panel
from demos.scene import faces_of, make_active, print_table

HAND, STEPPING, STANDING = "wrist.L", "foot.R", "foot.L"
TO_HEAD, TO_STEP, SINK_M = Vector((0.14, -0.10, 1.62)), Vector((-0.02, -0.26, 0.24)), 0.05
LOW_EAGERNESS = ("spine", "clavicle", "shoulder")  # the arm moves before the trunk
SHOWN_FRAMES = (1, 10, 17, 24, 36, 48)
WIDTH, HEIGHT = 300, 620


def add_goal(rig, bone: str, weight: float = 1.0, *, turned: bool = False):
    """Adds a goal at the end of a bone with the operator; returns its Empty."""
    before = set(bpy.data.objects)
    for each in rig.pose.bones:
        (each if hasattr(each, "select") else each.bone).select = each.name == bone
    rig.data.bones.active = rig.data.bones[bone]
    bpy.ops.sinew.add_goal()
    goal = (set(bpy.data.objects) - before).pop()
    goal.sinew.goal.position_weight, goal.sinew.goal.orientation_weight = weight, weight if turned else 0.0
    return goal


def key_locations(goal, locations: dict[int, Vector]) -> None:
    for frame, location in locations.items():
        goal.location = location
        goal.keyframe_insert("location", frame=frame)


def animate(rig) -> list:
    """Keys the goals and the sinking body; returns the goals."""
    bpy.ops.object.mode_set(mode="POSE")
    for bone in rig.pose.bones:
        if bone.name.startswith(LOW_EAGERNESS):
            bone.sinew.eagerness = 0.2
    hand, stepping = add_goal(rig, HAND), add_goal(rig, STEPPING, turned=True)
    standing = add_goal(rig, STANDING, 30.0, turned=True)
    start = hand.location.copy()
    key_locations(hand, {FRAME_START: start, PICTURE_FRAME: TO_HEAD, 30: TO_HEAD, FRAME_END: start})
    start = stepping.location.copy()
    lifted = start.lerp(start + TO_STEP, 0.5) + Vector((0, 0, 0.1))
    key_locations(
        stepping, {FRAME_START: start, 12: lifted, PICTURE_FRAME: start + TO_STEP, 30: start + TO_STEP, FRAME_END: start}
    )
    root = rig.pose.bones["root"]
    inward = root.bone.matrix_local.to_3x3().inverted()
    for frame, sink_m in ((FRAME_START, 0.0), (PICTURE_FRAME, SINK_M), (FRAME_END, 0.0)):
        root.location = inward @ Vector((0, 0, -sink_m))
        root.keyframe_insert("location", frame=frame)
    return [hand, stepping, standing]


def residuals_mm(rig, goals: list) -> np.ndarray:
    """(frames, goals): the distance of each bone's end from its goal, as Blender evaluates the baked keys."""
    residuals = []
    for frame in measures.FRAMES:
        bpy.context.scene.frame_set(frame)
        evaluated = rig.evaluated_get(bpy.context.evaluated_depsgraph_get())
        ends = [evaluated.matrix_world @ evaluated.pose.bones[goal.sinew.goal.bone].tail for goal in goals]
        residuals.append(
            [1000.0 * (end - goal.matrix_world.translation).length for end, goal in zip(ends, goals, strict=True)]
        )
    return np.array(residuals)


def main(output: Path) -> None:
    with step("the body, its muscles and goals"):
        bpy.ops.wm.read_factory_settings(use_empty=True)
        skin, rig = body_in_blender.build()
        scene = bpy.context.scene
        scene.frame_start, scene.frame_end = FRAME_START, FRAME_END
        make_active(rig)
        bpy.ops.sinew.add_preset(name="limbs")
        make_active(skin)
        skin.sinew.skin.elastic = True
        bpy.ops.sinew.bind()
        make_active(rig)
        goals = animate(rig)

    with step("the reach, baked"):
        start = time.perf_counter()
        bpy.ops.sinew.bake_reach(frame_start=FRAME_START, frame_end=FRAME_END, smoothness=0.003)
        bake_s = time.perf_counter() - start
        bpy.ops.object.mode_set(mode="OBJECT")

    with step("measures"):
        residuals = residuals_mm(rig, goals)
        points = measures.points_by_frame(skin)
        shown = [points[measures.FRAMES.index(frame)] for frame in SHOWN_FRAMES]

    with step("demo_reach.blend"):
        scene.frame_set(PICTURE_FRAME)
        bpy.ops.wm.save_as_mainfile(filepath=str(output / "demo_reach.blend"), compress=True)

    with step("demo_reach.png"):
        panels = tuple(
            Panel(
                f"frame {frame}", column, column * (WIDTH + GAP), 0, WIDTH, HEIGHT, (0.0, 0.0, 0.88), (0.75, -1.0, 0.15), 2.0
            )
            for column, frame in enumerate(SHOWN_FRAMES)
        )
        demo_picture.render_figures(output / "demo_reach.png", faces=faces_of(skin), figures=shown, panels=panels)

    print_table(
        {
            "bake of 48 frames": f"{bake_s:.1f} s, including playing all frames with the live skin",
            "hand from its goal": f"{residuals[:, 0].max():.2f} mm at most",
            "stepping foot from its goal": f"{residuals[:, 1].max():.2f} mm at most",
            "standing foot from its goal": f"{residuals[:, 2].max():.2f} mm at most; the body sinks {1000 * SINK_M:.0f} mm",
        }
    )


if __name__ == "__main__":
    main(Path(sys.argv[1]))
