"""Makes docs/panel.png: the Sinew tab and a whole human on Rigify's metarig, in a Blender with a window.

usage: blender --python scripts/pictures/panel.py -- OUTPUT.png

The extension must be installed. ImageMagick's `import` takes the picture of the X screen, because Blender's own screenshot
is black on a virtual screen.
"""

import subprocess
import sys

import bpy

OUTPUT = sys.argv[sys.argv.index("--") + 1]
BETWEEN_STEPS_S = 1.5


def viewport():
    """(window, area, region) of the 3D viewport."""
    window = bpy.context.window_manager.windows[0]
    area = next(area for area in window.screen.areas if area.type == "VIEW_3D")
    return window, area, next(region for region in area.regions if region.type == "WINDOW")


def begin():
    if "rigify" not in bpy.context.preferences.addons:
        bpy.ops.preferences.addon_enable(module="rigify")
    window, area, region = viewport()
    area.spaces.active.show_region_ui = True
    with bpy.context.temp_override(window=window, area=area, region=region):
        bpy.ops.object.select_all(action="SELECT")
        bpy.ops.object.delete()
        bpy.ops.object.armature_human_metarig_add()
        bpy.ops.sinew.add_preset(name="human")
        rig = bpy.context.object
        rig.sinew.rig.view = "MUSCLES"  # the metarig has no skin to see through
        rig.sinew.rig.show_empties = False
        for side in "LR":
            forearm = rig.pose.bones[f"forearm.{side}"]
            forearm.rotation_mode = "XYZ"
            forearm.rotation_euler.x = 1.4
        bpy.ops.view3d.view_axis(type="FRONT")
        bpy.ops.view3d.view_all()


def open_tab():
    _window, area, _region = viewport()
    next(region for region in area.regions if region.type == "UI").active_panel_category = "Sinew"
    bpy.data.objects["metarig"].sinew.rig.active_tissue = bpy.data.objects.find("Biceps brachii, long head.L")


def take_picture():
    subprocess.run(["import", "-window", "root", OUTPUT], check=True)


def end():
    bpy.ops.wm.quit_blender()


STEPS = [begin, open_tab, lambda: None, take_picture, end]


def step():
    STEPS.pop(0)()
    return BETWEEN_STEPS_S if STEPS else None


bpy.context.preferences.view.show_splash = False
bpy.app.timers.register(step, first_interval=BETWEEN_STEPS_S, persistent=True)
