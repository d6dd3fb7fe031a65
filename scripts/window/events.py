"""Clicks and drags as a person makes them: choosing a muscle, each of its handles, drawing a muscle, a reach, a preset.

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
        rig().sinew.rig.mirror_x = True
        bpy.ops.ed.undo_push(message="Example")


def handles(muscle: str = CHOSEN) -> dict[str, Vector]:
    from bl_ext.user_default.sinew.ui import muscle_gizmos

    return {name: Vector(point) for name, point in muscle_gizmos.points_of(bpy.data.objects[muscle]).items()}


def click_on_muscle():
    driver.focus()
    ends = handles()
    driver.click(driver.pixel_of(ends["ORIGIN"].lerp(ends["INSERTION"], 0.5)))  # in the middle of the belly


def a_muscle_is_chosen():
    active = bpy.context.view_layer.objects.active
    assert active.sinew.tissue.kind == "MUSCLE" and active.select_get(), active.name


def choose():
    from bl_ext.user_default.sinew.scene import selection

    with driver.in_viewport():
        selection.select(bpy.data.objects[CHOSEN])
        bpy.ops.ed.undo_push(message="Choose")


def add_via_point():
    with driver.in_viewport():
        bpy.ops.sinew.add_via_point()
        choose()


def look_at_the_arm():
    """From near, so that the handles do not cover each other."""
    view = driver.parts()[1].spaces.active.region_3d
    view.view_location = handles()["WIDTH_X"]
    view.view_distance *= 0.3


def drag(name: str):
    """Drags a handle and keeps the button down."""

    def step():
        _kept["before"] = handles()
        x, y = driver.pixel_of(_kept["before"][name])
        driver.focus()
        driver.move((x, y))
        driver.xdotool("mousedown", 1)
        for part in range(1, 6):
            driver.xdotool("mousemove", x + 4 * part, y + 8 * part)

    return step


def release():
    driver.xdotool("mouseup", 1)


def escape():
    driver.xdotool("key", "Escape")
    driver.xdotool("mouseup", 1)


def moved(name: str) -> float:
    return (handles()[name] - _kept["before"][name]).length


def has_moved(name: str):
    def step():
        assert moved(name) > 0.002, (name, moved(name))
        # the twin has the mirror image of the handle
        twin = CHOSEN.removesuffix("L") + "R"
        other = handles(twin)[name]
        own = handles()[name]
        assert (Vector((-other.x, other.y, other.z)) - own).length < 2e-3, (name, own, other)

    return step


def is_back():
    assert all(moved(name) < 1e-4 for name in _kept["before"]), {name: moved(name) for name in _kept["before"]}


def undo():
    with driver.in_viewport():
        bpy.ops.ed.undo()


def each_of(*names: str) -> list:
    """Steps that drag each handle, check it and its twin, and undo that with one step; then one ended with Esc."""
    steps = []
    for name in names:
        steps += [drag(name), driver.wait, release, driver.wait, has_moved(name), undo, driver.wait, is_back]
    return [*steps, drag("INSERTION"), driver.wait, escape, driver.wait, is_back]


def look_from_the_front():
    with driver.in_viewport():
        bpy.ops.view3d.view_axis(type="FRONT")
        bpy.ops.view3d.view_all()


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
    assert len(rig().children) == _kept["count"] + 2 and drawn.sinew.tissue.kind == "MUSCLE"
    assert (drawn.sinew.tissue.origin_bone, drawn.sinew.tissue.insertion_bone) == ("upper_arm.L", "forearm.L")
    assert took_s < LONGEST_DRAWING_S, took_s
    print(f"drawn in {took_s:.1f} s, with its twin", flush=True)


def start_drawing():
    start_tool()
    click_origin()
    click_insertion()


def nothing_was_drawn():
    assert len(rig().children) == _kept["count"]


def start_reach():
    with driver.in_viewport():
        bpy.ops.wm.tool_set_by_id(name="builtin.select_box")
        bpy.ops.sinew.repair(what="POSE_MODE", name=rig().name)
        rig().data.bones.active = rig().data.bones["forearm.L"]
        bpy.ops.sinew.reach("INVOKE_DEFAULT")


def wrist() -> Vector:
    return rig().matrix_world @ rig().pose.bones["forearm.L"].tail


def drag_wrist():
    _kept["wrist"], (x, y) = wrist(), driver.pixel_of(wrist())
    driver.focus()
    driver.move((x, y))
    driver.xdotool("mousedown", 1)
    for part in range(1, 9):
        driver.xdotool("mousemove", x - 15 * part, y - 20 * part)
    driver.xdotool("mouseup", 1)


def the_wrist_is_at_the_mouse():
    from bl_ext.user_default.sinew.display import reach_overlay

    end, goal = reach_overlay.points()
    assert (wrist() - _kept["wrist"]).length > 0.05 and (Vector(end) - Vector(goal)).length < 2e-3, (end, goal)
    _kept["reached"] = wrist()


def click_timeline():
    window = driver.parts()[0]
    timeline = next(area for area in window.screen.areas if area.type == "DOPESHEET_EDITOR")
    driver.click((timeline.x + timeline.width // 2, window.height - timeline.y - 36))


def the_wrist_stays():
    assert (wrist() - _kept["reached"]).length < 1e-6 and bpy.context.scene.frame_current != 1


def the_wrist_is_back():
    assert (wrist() - _kept["wrist"]).length < 1e-4


def object_mode():
    with driver.in_viewport():
        bpy.ops.object.mode_set(mode="OBJECT")
        bpy.context.scene.frame_current = 1


def show_assets():
    """The Asset Browser with Sinew's presets, where the timeline was."""
    with driver.in_viewport():
        bpy.ops.sinew.make_assets()
    window = driver.parts()[0]
    area = next(area for area in window.screen.areas if area.type == "DOPESHEET_EDITOR")
    area.ui_type = "ASSETS"
    _kept["assets"] = area


def choose_library():
    _kept["assets"].spaces.active.params.asset_library_reference = "Sinew Presets"
    _kept["count"] = len(rig().children)


def drop_first_asset():
    """Drags the first asset, beside the list of catalogs, on the chest."""
    area, window = _kept["assets"], driver.parts()[0]
    main = next(region for region in area.regions if region.type == "WINDOW")
    x, y = main.x + 45, window.height - (main.y + main.height - 40)
    chest = driver.pixel_of(rig().matrix_world @ rig().pose.bones["spine.003"].head)
    driver.focus()
    driver.move((x, y))
    driver.xdotool("mousedown", 1)
    for part in range(1, 9):
        driver.xdotool("mousemove", x + (chest[0] - x) * part // 8, y + (chest[1] - y) * part // 8)
    driver.xdotool("mouseup", 1)


def the_preset_was_dropped():
    from bl_ext.user_default.sinew.muscles import preset_assets

    assert not any(preset_assets.PROPERTY in found for found in bpy.data.objects)
    assert bpy.context.object == rig(), bpy.context.object


WAIT = driver.wait
driver.run(
    [
        example, driver.open_sidebar, WAIT, driver.open_tab, WAIT,
        click_on_muscle, WAIT, a_muscle_is_chosen,
        choose, WAIT, look_at_the_arm, WAIT, *each_of("ORIGIN", "INSERTION", "WIDTH_X"),
        add_via_point, WAIT, *each_of("VIA 0"), look_from_the_front, WAIT,
        start_drawing, WAIT, escape, WAIT, nothing_was_drawn,
        start_tool, WAIT, click_origin, click_insertion, set_width, confirm, WAIT, a_muscle_was_drawn,
        start_reach, WAIT, drag_wrist, WAIT, the_wrist_is_at_the_mouse, click_timeline, WAIT, the_wrist_stays,
        escape, WAIT, the_wrist_is_back, object_mode, WAIT,
        show_assets, WAIT, choose_library, WAIT, WAIT, look_from_the_front, WAIT,
        drop_first_asset, WAIT, WAIT, the_preset_was_dropped,
    ]
)  # fmt: skip
