"""Renders the muscles that *Add Muscles* chooses for a character, as ellipsoids in its translucent mesh.

usage: python3 scripts/run_in_blender.py scripts/pictures/creatures.py FILE [--out FILE.png] [--view side|front|top|oblique]
       [--creature NAME]

FILE is a .glb, .gltf, .vrm, .fbx or .blend file with a rigged character. The picture is seen from the character's left side.
The last line printed is the report of the operator.
"""

import argparse
import sys
from pathlib import Path

import bpy
from benchmarks.recognition_table import captured, load
from bl_ext.user_default.sinew.muscles.placing.recognise import names
from bl_ext.user_default.sinew.muscles.placing.recognise.body_space import body_space
from bl_ext.user_default.sinew.scene import characters, tissue_empty
from bl_ext.user_default.sinew.skin.main_skin import main_skin_of
from build.layout import ROOT
from mathutils import Matrix, Vector

from pictures.anatomy import draw, render

# Where the camera is, in axes of the body: left, back, up.
VIEWS = {"side": (1, -0.15, 0.1), "front": (0.3, -1, 0.1), "top": (0.05, -0.1, 1), "oblique": (1, -0.9, 0.5)}
MARGIN = 1.15
SIZE_M = 1.5  # the renderer's camera is 3 m away


def main():
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("file", metavar="FILE", type=Path)
    parser.add_argument("--out", metavar="FILE.png", type=Path)
    parser.add_argument("--view", choices=VIEWS, default="side")
    parser.add_argument("--creature", default="AUTO", help="as in the operator (default: recognized)")
    wanted = parser.parse_args(sys.argv[1:])
    lines: list[str] = []
    with captured(lines):
        rig = load(wanted.file)
        _make_active(rig)
        bpy.ops.sinew.add_muscles(creature=wanted.creature)
    shapes = [tissue_empty.read(empty, rig) for empty in characters.tissues_of(rig)]
    readings = names.readings_of(rig)
    to_body = body_space(rig, readings, list(rig.data.bones)).to_body.to_3x3()
    skin = main_skin_of(rig)
    to_armature = rig.matrix_world.inverted() @ skin.matrix_world
    skin.parent = None
    skin.matrix_world = to_armature
    skin.modifiers.clear()
    corners = [to_armature @ Vector(corner) for corner in skin.bound_box]
    draw(shapes, skin)
    corners = [to_body @ corner for corner in corners]
    scale = SIZE_M / max(
        max(corner[axis] for corner in corners) - min(corner[axis] for corner in corners) for axis in range(3)
    )
    to_picture = Matrix.Scale(scale, 4) @ to_body.to_4x4()  # axes of the body, so that the camera's up is the body's
    for found in bpy.context.scene.objects:
        found.matrix_world = to_picture @ found.matrix_world
    corners = [corner * scale for corner in corners]
    middle = sum(corners, Vector()) / len(corners)
    view = Vector(VIEWS[wanted.view]).normalized()
    side = Vector((0, 0, 1)).cross(view).normalized()
    across, high = (max(abs((corner - middle).dot(axis)) for corner in corners) * 2 for axis in (side, view.cross(side)))
    size = (1000, max(int(1000 * high / across), 300)) if across > high else (max(int(900 * across / high), 300), 900)
    render(view, middle, MARGIN * max(across, high), size, wanted.out or ROOT / "docs" / f"{wanted.file.stem}.png")
    print("\n".join(line for line in lines if line.startswith(("Info", "Warning"))))


def _make_active(rig):
    if bpy.context.object and bpy.context.object.mode != "OBJECT":
        bpy.ops.object.mode_set(mode="OBJECT")
    for found in bpy.context.view_layer.objects:
        found.select_set(False)
    rig.hide_set(False)
    rig.select_set(True)
    bpy.context.view_layer.objects.active = rig
    rig.data.pose_position = "REST"


if __name__ == "__main__":
    main()
