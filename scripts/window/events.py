"""Clicks and drags as a person makes them: choosing a muscle, dragging a handle, drawing a muscle, the pie menu.

usage: blender --python scripts/window/events.py

The extension must be installed, and xdotool. Each step checks what the event did; the exit code is 1 if one failed.
"""

import sys
import time
from pathlib import Path

sys.path.append(str(Path(__file__).resolve().parents[1]))

import bpy
from mathutils import Vector

from window import driver

CHOSEN = "Biceps brachii, long head.L"
LONGEST_DRAWING_S = 15.0
_kept: dict = {}


def rig():
    return next(found for found in bpy.data.objects if found.type == "ARMATURE")


def example():
    with driver.in_viewport():
        bpy.ops.object.select_all(action="SELECT")
        bpy.ops.object.delete()
        bpy.ops.sinew.example_character()
        bpy.ops.view3d.view_axis(type="FRONT")
        bpy.ops.view3d.view_all()
        bpy.ops.ed.undo_push(message="Example")


def handles() -> dict[str, Vector]:
    from bl_ext.user_default.sinew.ui import muscle_gizmos

    return {name: Vector(point) for name, point in muscle_gizmos.points_of(bpy.data.objects[CHOSEN]).items()}


def click_on_muscle():
    driver.focus()
    ends = handles()
    driver.click(driver.pixel_of(ends["ORIGIN"].lerp(ends["INSERTION"], 0.5)))


def a_muscle_is_chosen():
    active = bpy.context.view_layer.objects.active
    assert active.sinew.tissue.kind == "MUSCLE" and active.select_get(), active.name


def choose():
    from bl_ext.user_default.sinew.scene import selection

    with driver.in_viewport():
        selection.select(bpy.data.objects[CHOSEN])
        bpy.ops.ed.undo_push(message="Choose")


def drag_insertion():
    _kept["before"] = handles()
    x, y = driver.pixel_of(_kept["before"]["INSERTION"])
    driver.focus()
    driver.move((x, y))
    driver.xdotool("mousedown", 1)
    for part in range(1, 6):
        driver.xdotool("mousemove", x + 4 * part, y + 6 * part)


def release():
    driver.xdotool("mouseup", 1)


def the_insertion_moved():
    before, after = _kept["before"], handles()
    assert (after["INSERTION"] - before["INSERTION"]).length > 0.005
    assert (after["ORIGIN"] - before["ORIGIN"]).length < 1e-4


def undo():
    with driver.in_viewport():
        bpy.ops.ed.undo()


def the_drag_is_undone():
    assert (handles()["INSERTION"] - _kept["before"]["INSERTION"]).length < 1e-4


def start_tool():
    with driver.in_viewport():
        bpy.ops.wm.tool_set_by_id(name="sinew.draw_muscle_tool")
    _kept["count"] = len(rig().children)
    bones = rig().pose.bones
    _kept["ends"] = [
        driver.pixel_of(rig().matrix_world @ bones[bone].head.lerp(bones[bone].tail, 0.5))
        for bone in ("upper_arm.L", "forearm.L")
    ]


def click_origin():
    _kept["start_s"] = time.time()
    driver.focus()
    driver.click(_kept["ends"][0])


def click_insertion():
    driver.click(_kept["ends"][1])


def set_width():
    (left, top), (right, bottom) = _kept["ends"]
    middle = (left + right) // 2, (top + bottom) // 2
    for part in range(4):
        driver.xdotool("mousemove", middle[0] + 4 * part, middle[1] - 4 * part)
    driver.xdotool("click", 4)


def confirm():
    driver.xdotool("mousedown", 1)
    driver.xdotool("mouseup", 1)


def a_muscle_was_drawn():
    drawn = bpy.context.view_layer.objects.active
    took_s = time.time() - _kept["start_s"]
    assert len(rig().children) == _kept["count"] + 1 and drawn.sinew.tissue.kind == "MUSCLE"
    assert (drawn.sinew.tissue.origin_bone, drawn.sinew.tissue.insertion_bone) == ("upper_arm.L", "forearm.L")
    assert took_s < LONGEST_DRAWING_S, took_s
    print(f"drawn in {took_s:.1f} s", flush=True)


driver.run(
    [
        example, driver.open_sidebar, driver.wait, driver.open_tab, driver.wait,
        click_on_muscle, driver.wait, a_muscle_is_chosen,
        choose, driver.wait, drag_insertion, driver.wait, release, driver.wait, the_insertion_moved,
        undo, driver.wait, the_drag_is_undone,
        start_tool, driver.wait, click_origin, click_insertion, set_width, confirm, driver.wait, a_muscle_was_drawn,
    ]
)  # fmt: skip
