"""Records docs/first_minute.gif: a character, one click for muscles, one to bind, one to pose, and an arm that bends.

usage: blender --python scripts/window/first_minute.py -- BODY.blend FOLDER

Also makes the pictures for the extensions platform: preview.png and icon.png. FOLDER is docs.

`python3 scripts/body.py --output BODY.blend` makes the body. In a Blender with a window. The extension must be installed,
xdotool and ImageMagick.
"""

import math
import sys
import tempfile
from pathlib import Path

sys.path.append(str(Path(__file__).resolve().parents[1]))

import bpy
from mathutils import Euler

from window import driver, recorder

BODY, FOLDER = (Path(word) for word in sys.argv[sys.argv.index("--") + 1 :])
FOREARM = "lowerarm01.L"
BEND_STEPS, BEND_DEG = 12, 105.0
TURN = Euler((1.35, 0.0, 0.6))
MOST_CLICKS = 4
_clicks = 0
_start_rad: list[float] = []  # the direction of the mouse from the joint before it bends
_recorder = recorder.Recorder(Path(tempfile.mkdtemp()), crop="1313x985+0+0")


def rig():
    return bpy.data.objects["Rig"]


def import_body():
    with driver.in_viewport():
        bpy.ops.object.select_all(action="SELECT")
        bpy.ops.object.delete()
        with bpy.data.libraries.load(str(BODY), link=False) as (held, wanted):
            wanted.objects = held.objects
        for found in wanted.objects:
            bpy.context.scene.collection.objects.link(found)
        bpy.context.view_layer.objects.active = rig()
        rig().select_set(True)
        rig().data.display_type = "STICK"
        bpy.ops.view3d.view_all()
        view = driver.parts()[1].spaces.active.region_3d
        view.view_rotation = TURN.to_quaternion()
        view.view_distance *= 0.52
        view.view_location.z += 0.35
        bpy.ops.object.select_all(action="DESELECT")
        rig().select_set(True)
    driver.focus()


def button(row_px: int) -> tuple[int, int]:
    """The position of a button in the sidebar: its middle, row_px below the top of the sidebar."""
    window, area, _region = driver.parts()
    sidebar = next(found for found in area.regions if found.type == "UI")
    return sidebar.x + sidebar.width // 2 - 10, window.height - (sidebar.y + sidebar.height) + row_px


def click_at(position):
    def step():
        global _clicks
        _recorder.move(position() if callable(position) else position)
        _recorder.click()
        _clicks += 1

    return step


def look():
    _recorder.look()


def forearm() -> tuple[int, int]:
    bone = rig().pose.bones[FOREARM]
    return driver.pixel_of(rig().matrix_world @ bone.head.lerp(bone.tail, 0.5))


def start_to_rotate():
    """R, and X twice for the bone's own axis."""
    for key in ("r", "x", "x"):
        driver.xdotool("key", key)


def bend(part: int):
    def step():
        bone = rig().pose.bones[FOREARM]
        x, y = driver.pixel_of(rig().matrix_world @ bone.head)
        start = forearm()
        if part == 1:
            _start_rad.append(math.atan2(start[1] - y, start[0] - x))
        angle = _start_rad[0] + math.radians(BEND_DEG) * part / BEND_STEPS
        radius = math.hypot(start[0] - x, start[1] - y) + 60.0 * part / BEND_STEPS
        position = round(x + radius * math.cos(angle)), round(y + radius * math.sin(angle))
        driver.xdotool("mousemove", *position)
        _recorder.follow(position)

    return step


def look_briefly():
    _recorder.look(hold_cs=8)


def confirm():
    driver.xdotool("key", "Return")


def the_arm_is_bent():
    angle = rig().pose.bones[FOREARM].matrix_basis.to_quaternion().angle
    assert math.degrees(angle) > 60.0, math.degrees(angle)
    assert rig().sinew.rig.view == "XRAY" and bpy.data.objects["Body"].modifiers[0].type == "NODES"
    assert _clicks <= MOST_CLICKS, _clicks
    print(f"{_clicks} clicks from an imported character to a bent arm in X-ray", flush=True)


def save():
    _recorder.look(hold_cs=recorder.LAST_CS)
    _recorder.save(FOLDER / "first_minute.gif")


def show_the_body_alone():
    space = driver.parts()[1].spaces.active
    space.show_region_ui = space.show_region_toolbar = space.show_gizmo = space.overlay.show_overlays = False


def platform_pictures():
    """The preview has 1920 x 1080 pixels and the icon 256 x 256, as the platform wants them."""
    for name, crop, size in (("preview.png", "1311x737+0+110", "1920x1080!"), ("icon.png", "440x440+460+110", "256x256")):
        driver.crop(FOLDER / name, crop, size)


LARGE_BUTTON = {"Add Muscles": 84, "Bind Skin": 105, "Pose It": 105}
driver.run(
    [
        import_body, driver.open_sidebar, driver.wait, driver.open_tab, driver.wait, look,
        click_at(lambda: button(LARGE_BUTTON["Add Muscles"])), *[driver.wait] * 4, look,
        click_at(lambda: button(LARGE_BUTTON["Bind Skin"])), *[driver.wait] * 4, look,
        click_at(lambda: button(LARGE_BUTTON["Pose It"])), *[driver.wait] * 3, look,
        click_at(forearm), driver.wait, look, start_to_rotate,
        *[step for part in range(1, BEND_STEPS + 1) for step in (bend(part), look_briefly)],
        confirm, driver.wait, the_arm_is_bent, save, show_the_body_alone, driver.wait, driver.wait, platform_pictures,
    ]
)  # fmt: skip
