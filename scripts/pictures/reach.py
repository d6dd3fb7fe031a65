"""Makes docs/reach_hand.png and docs/reach_foot.png: a hand is dragged to the head and a foot to a step, with a live skin.

usage: blender --enable-event-simulate BODY.blend --python scripts/pictures/reach.py -- OUTPUT_DIR

`python3 scripts/body.py --output BODY.blend` saves BODY.blend. The extension must be installed. Mouse and keys are
simulated, because the modal operator must run. ImageMagick's `import` takes the pictures of the X screen, because Blender's
own screenshot is black on a virtual screen.
"""

import subprocess
import sys
from pathlib import Path

import bpy
from bpy_extras import view3d_utils
from mathutils import Vector

OUTPUT = Path(sys.argv[sys.argv.index("--") + 1])
BETWEEN_STEPS_S = 0.4
DRAG_STEPS = 12
STEP = Vector((-0.16, -0.42, 0.24))  # the target of the right foot, on the box


def viewport():
    """(window, area, region) of the 3D viewport."""
    window = bpy.context.window_manager.windows[0]
    area = next(area for area in window.screen.areas if area.type == "VIEW_3D")
    return window, area, next(region for region in area.regions if region.type == "WINDOW")


def in_viewport():
    window, area, region = viewport()
    return bpy.context.temp_override(window=window, area=area, region=region)


def on_screen(point: Vector) -> tuple[int, int]:
    """The position of a world-space point in the window, in pixels."""
    _window, area, region = viewport()
    x, y = view3d_utils.location_3d_to_region_2d(region, area.spaces.active.region_3d, point)
    return int(region.x + x), int(region.y + y)


def simulate(kind: str, value: str, at: tuple[int, int], **held):
    viewport()[0].event_simulate(type=kind, value=value, x=at[0], y=at[1], **held)


def rig():
    return bpy.data.objects["Rig"]


def end_of(bone: str) -> Vector:
    return rig().matrix_world @ rig().pose.bones[bone].tail


def scene():
    """Builds the body with muscles and a bound, elastic skin, the armature in Pose Mode, and a box to step on."""
    _window, area, _region = viewport()
    area.spaces.active.show_region_ui = True
    area.spaces.active.overlay.show_bones = False  # the face has many bones
    body = bpy.data.objects["Body"]
    with in_viewport():
        bpy.ops.mesh.primitive_cube_add(size=1.0, location=(STEP.x, STEP.y - 0.05, 0.1), scale=(0.3, 0.4, 0.2))
        bpy.context.object.select_set(False)
        bpy.context.view_layer.objects.active = rig()
        bpy.ops.sinew.add_preset(name="limbs")
        body.sinew.skin.elastic = True
        bpy.context.view_layer.objects.active = body
        bpy.ops.sinew.bind()
        rig().sinew.rig.show_empties = False
        rig().sinew.rig.show_shaded = False
        bpy.context.view_layer.objects.active = rig()
        rig().data.display_type = "STICK"
        for bone in rig().pose.bones:
            if bone.name.startswith(("spine", "clavicle", "shoulder")):
                bone.sinew.eagerness = 0.2  # the arms move before the trunk
        bpy.ops.object.mode_set(mode="POSE")
        bpy.ops.view3d.view_axis(type="FRONT")
        bpy.ops.view3d.view_all()
    bpy.context.window_manager.sinew_show_times = True


def open_tab():
    _window, area, _region = viewport()
    next(region for region in area.regions if region.type == "UI").active_panel_category = "Sinew"


def begin_tool(bone: str):
    rig().data.bones.active = rig().data.bones[bone]
    window, area, _region = viewport()
    sidebar = next(region for region in area.regions if region.type == "UI")  # where the button is
    with bpy.context.temp_override(window=window, area=area, region=sidebar):
        bpy.ops.sinew.reach("INVOKE_DEFAULT")


def drag(bone: str, to: Vector):
    """The steps of a drag with the mouse button held, from the end of a bone to a position."""
    start, target = on_screen(end_of(bone)), on_screen(to)
    yield lambda: simulate("MOUSEMOVE", "NOTHING", start)
    yield lambda: simulate("LEFTMOUSE", "PRESS", start)
    for step in range(1, DRAG_STEPS + 1):
        t = step / DRAG_STEPS
        at = tuple(int(a + (b - a) * t) for a, b in zip(start, target, strict=True))
        yield lambda at=at: simulate("MOUSEMOVE", "NOTHING", at)
    yield lambda: simulate("LEFTMOUSE", "RELEASE", target)


def picture(name: str):
    hand, foot = (tuple(round(part, 3) for part in end_of(bone)) for bone in ("wrist.L", "foot.R"))
    print(f"{name}: hand at {hand}, foot at {foot}")
    left = ["-crop", "1030x870+0+30", "-resize", "70%", "+dither", "-colors", "200"]  # the viewport
    subprocess.run(["import", "-window", "root", *left, str(OUTPUT / name)], check=True)


def view(axis: str):
    with in_viewport():
        bpy.ops.view3d.view_axis(type=axis)
        bpy.ops.view3d.view_all()


def orbit_view():
    with in_viewport():
        bpy.ops.view3d.view_orbit(angle=0.6, type="ORBITLEFT")
        bpy.ops.view3d.view_orbit(angle=0.25, type="ORBITUP")


def work():
    """All steps. Blender draws after each of them."""
    yield scene
    yield open_tab
    yield lambda: None
    # the hand: in the view plane, then away from the viewer, with the mouse wheel
    yield lambda: begin_tool("wrist.L")
    head = end_of("head").lerp(rig().matrix_world @ rig().pose.bones["head"].head, 0.5) + Vector((0.13, 0, 0))
    yield from drag("wrist.L", head)
    at = on_screen(head)
    for _ in range(3):
        yield lambda: simulate("WHEELUPMOUSE", "PRESS", at)
    yield lambda: picture("reach_hand_front.png")
    yield lambda: simulate("RET", "PRESS", at)
    yield lambda: view("LEFT" if STEP.y > 0 else "RIGHT")
    yield lambda: None
    # the foot: from the side
    yield lambda: begin_tool("foot.R")
    yield lambda: simulate("O", "PRESS", on_screen(STEP))  # the foot stays level
    yield from drag("foot.R", STEP)
    yield lambda: simulate("RET", "PRESS", on_screen(STEP))
    yield lambda: picture("reach_foot.png")
    yield lambda: view("FRONT")
    yield orbit_view
    yield lambda: None
    yield lambda: picture("reach_hand.png")
    # Esc restores the pose
    before = [pose_bone.matrix_basis.copy() for pose_bone in rig().pose.bones]
    yield lambda: begin_tool("wrist.R")
    yield from drag("wrist.R", Vector((-0.3, -0.2, 1.2)))
    print("moved before Esc:", before != [pose_bone.matrix_basis for pose_bone in rig().pose.bones])
    yield lambda: simulate("ESC", "PRESS", on_screen(Vector((-0.3, -0.2, 1.2))))
    yield lambda: None
    print("restored by Esc:", before == [pose_bone.matrix_basis for pose_bone in rig().pose.bones])
    yield bpy.ops.wm.quit_blender


STEPS = work()


def step():
    done = next(STEPS, None)
    if done is None:
        return None
    done()
    return BETWEEN_STEPS_S


bpy.context.preferences.view.show_splash = False
bpy.app.timers.register(step, first_interval=2.0, persistent=True)
