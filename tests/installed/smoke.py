"""Runs in a real Blender with a window: invokes every operator as its button does, and drives dialogs and modals by events.

usage: blender --enable-event-simulate --factory-startup --python smoke.py -- ZIP RESULT

ZIP is Sinew's extension, which is installed as a user installs it. RESULT becomes a JSON file: a list of what happened, with
a text for everything that is wrong.
"""

import json
import math
import sys
import time
import traceback
from pathlib import Path

import bpy

ZIP, RESULT = (str(Path(name).resolve()) for name in sys.argv[sys.argv.index("--") + 1 :])
LONGEST_S = 60.0  # for one operator
FRAMES = 120
# operators that need another mode or active object than the armature in Object Mode
IN_POSE_MODE = ("add_goal", "reach", "rotate_joint", "copy_bone_settings")
ON_THE_MESH = ("unbind", "paint_region", "bake_cache")
ON_A_MUSCLE = ("add_via_point", "copy_settings", "remove_via_points", "wrap")
FILE_BROWSERS = ("export", "load_musculature", "save_musculature")
BAKES = ("bake_shape_keys", "bake_cache", "bake_correctives", "bake_bones", "measure")
results: list[dict] = []


def install():
    view = bpy.context.preferences.view
    view.show_splash, view.filebrowser_display_type = False, "SCREEN"
    bpy.ops.extensions.package_install_files(filepath=ZIP, repo="user_default", enable_on_install=True)


def operators() -> list[str]:
    return sorted(name for name in dir(bpy.ops.sinew) if not name.startswith("_"))


def build():
    """A bound arm of two bones that bends over the frames, with two muscles; the muscles' names are of their operator."""
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    armature = bpy.data.armatures.new("Rig")
    rig = bpy.data.objects.new("Rig", armature)
    bpy.context.scene.collection.objects.link(rig)
    with override():
        activate(rig)
        bpy.ops.object.mode_set(mode="EDIT")
        upper, lower = armature.edit_bones.new("upper"), armature.edit_bones.new("lower")
        upper.head, upper.tail, lower.head, lower.tail = (0, 0, 0), (0.3, 0, 0), (0.3, 0, 0), (0.6, 0, 0)
        lower.parent = upper
        bpy.ops.object.mode_set(mode="OBJECT")
        skin = arm_mesh(rig)
        for around in (-0.5 * math.pi, 0.5 * math.pi):
            activate(rig)
            bpy.ops.sinew.add_tissue(kind="MUSCLE", origin_bone="upper", insertion_bone="lower", around=around)
        bone = rig.pose.bones["lower"]
        bone.rotation_mode = "XYZ"
        for frame, angle in ((1, 0.0), (FRAMES, 1.2)):
            bone.rotation_euler[2] = angle
            bone.keyframe_insert("rotation_euler", frame=frame)
        bpy.context.scene.frame_start, bpy.context.scene.frame_end = 1, FRAMES
        activate(skin)
        bpy.ops.sinew.bind()
        bpy.context.scene.frame_set(5)
        activate(rig)
    return skin, rig


def arm_mesh(rig):
    rings, around = 24, 20
    points = [
        (0.6 * ring / (rings - 1), 0.05 * math.cos(2 * math.pi * a / around), 0.05 * math.sin(2 * math.pi * a / around))
        for ring in range(rings)
        for a in range(around)
    ]
    faces = [
        (r * around + a, r * around + (a + 1) % around, (r + 1) * around + (a + 1) % around, (r + 1) * around + a)
        for r in range(rings - 1)
        for a in range(around)
    ]
    mesh = bpy.data.meshes.new("Arm")
    mesh.from_pydata(points, [], faces)
    skin = bpy.data.objects.new("Arm", mesh)
    bpy.context.scene.collection.objects.link(skin)
    for bone, sign in (("upper", -1.0), ("lower", 1.0)):
        group = skin.vertex_groups.new(name=bone)
        for index, (x, _y, _z) in enumerate(points):
            group.add([index], min(max(0.5 + sign * (x - 0.3) / 0.12, 0.0), 1.0), "REPLACE")
    skin.parent = rig
    skin.modifiers.new("Armature", "ARMATURE").object = rig
    return skin


def window():
    return bpy.context.window_manager.windows[0]


def override():
    area = next(area for area in window().screen.areas if area.type == "VIEW_3D")
    region = next(region for region in area.regions if region.type == "WINDOW")
    return bpy.context.temp_override(window=window(), area=area, region=region)


def activate(*objects):
    for other in bpy.context.view_layer.objects:
        other.select_set(False)
    for chosen in objects:
        chosen.select_set(True)
    bpy.context.view_layer.objects.active = objects[0]


def press(key: str, value: str = "PRESS"):
    w = window()
    w.event_simulate(key, value, x=w.width // 2, y=w.height // 2)


def running() -> list[str]:
    return [operator.bl_idname for operator in window().modal_operators if operator.bl_idname.startswith("SINEW_OT")]


def state(skin, rig) -> dict:
    scene = bpy.context.scene
    return {
        "frame": scene.frame_current,
        "mode": rig.mode,
        "live": skin.sinew.skin.live,
        "objects": sorted(found.name for found in bpy.data.objects),
        "keys": skin.data.shape_keys.key_blocks.keys() if skin.data.shape_keys else [],
        "angle": round(rig.pose.bones["lower"].rotation_euler[2], 5),
    }


def prepare(name: str, skin, rig):
    if name in ON_THE_MESH:
        activate(skin)
    elif name in ON_A_MUSCLE:
        muscles = [found for found in rig.children if found.type == "EMPTY"]
        activate(*muscles)
    elif name == "wrap":
        return
    elif name in IN_POSE_MODE:
        bpy.ops.object.mode_set(mode="POSE")
        rig.data.bones.active = rig.data.bones["lower"]
        if hasattr(rig.pose.bones["lower"], "select"):
            rig.pose.bones["lower"].select = True
        else:
            rig.data.bones["lower"].select = True


def invoke(name: str) -> str:
    """Invokes an operator as its button does. Returns an error that it reported, or an empty text."""
    with override():
        try:
            getattr(bpy.ops.sinew, name)("INVOKE_DEFAULT")
        except RuntimeError as error:
            return str(error).strip()
    return ""


def key(name: str):
    press(name)
    yield 0.1
    press(name, "RELEASE")
    yield 0.2


def until_it_ends(name: str):
    begin = time.monotonic()
    while running():
        if time.monotonic() - begin > LONGEST_S:
            raise AssertionError(f"{name} still runs after {LONGEST_S} s")
        yield 0.05


def confirmed(name: str):
    """Invokes an operator and confirms what it shows, with Enter."""
    skin, rig = build()
    yield 0.3
    with override():
        prepare(name, skin, rig)
    yield 0.2
    error = invoke(name)
    yield 0.4
    yield from key("ESC" if name in FILE_BROWSERS else "RET")
    if name == "reach":
        press("MOUSEMOVE", "NOTHING")
        yield 0.2
        yield from key("RET")
    yield from until_it_ends(name)
    results.append({"operator": name, "how": "confirmed", "error": error})


def escaped(name: str):
    """Starts an operator and ends it with Esc while it works: everything is as before."""
    skin, rig = build()
    yield 0.3
    with override():
        prepare(name, skin, rig)
    yield 0.2
    before = state(skin, rig)
    invoke(name)
    yield 0.4
    if name != "reach":
        yield from key("RET")
    was_running = bool(running())
    yield from key("ESC")
    yield from until_it_ends(name)
    yield 0.3
    after = state(bpy.data.objects["Arm"], bpy.data.objects["Rig"])
    wrong = "" if after == before else f"before {before}, after {after}"
    results.append({"operator": name, "how": "escaped", "was running": was_running, "wrong": wrong})


def baked(name: str):
    """Runs a bake to its end: it has an effect, and mode and frame are as before."""
    skin, rig = build()
    yield 0.3
    with override():
        prepare(name, skin, rig)
    before = state(skin, rig)
    invoke(name)
    yield 0.4
    yield from key("RET")
    yield from until_it_ends(name)
    yield 0.3
    skin, rig = bpy.data.objects["Arm"], bpy.data.objects["Rig"]
    after = state(skin, rig)
    settings = skin.sinew.skin
    has_effect = bool(len(settings.baked_keys) or rig.sinew.rig.export_copy or settings.cache_modifier or name == "measure")
    same = all(after[field] == before[field] for field in ("frame", "mode", "angle"))
    wrong = "" if has_effect and same else f"effect {has_effect}, before {before}, after {after}"
    results.append({"operator": name, "how": "baked", "wrong": wrong})


def work():
    install()
    yield 1.0
    names = operators()
    bpy.ops.wm.save_userpref()
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    yield 0.5
    for name in names:
        yield from confirmed(name)
    for name in BAKES:
        if name != "bake_cache":
            yield from baked(name)
    for name in (*BAKES, "reach"):
        yield from escaped(name)


worker = work()


def step():
    try:
        return next(worker)
    except StopIteration:
        results.append({"operator": "", "how": "all", "count": len(operators())})
    except BaseException:
        traceback.print_exc()
        results.append({"operator": "", "how": "stopped", "wrong": traceback.format_exc()})
    Path(RESULT).write_text(json.dumps(results, indent=1))
    bpy.ops.wm.quit_blender()
    return None


bpy.app.timers.register(step, first_interval=1.0, persistent=True)
