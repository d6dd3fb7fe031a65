"""Renders a turntable in one picture: a row for each flexed joint, seen from several sides, with Cycles on the CPU."""

import math
import tempfile
from dataclasses import dataclass
from pathlib import Path

import bpy
import numpy as np
from demos import picture as demo_picture
from mathutils import Matrix, Vector
from PIL import Image

from benchmarks import quality_poses
from benchmarks.quality_character import SINEW, Character

TILE, GAP = 200, 4
TURNS = (-70, -35, 0, 35, 70)  # degrees about the vertical, from the middle view of each row
SAMPLES = 24


@dataclass(frozen=True)
class Row:
    """A pose, the joint in the middle of the picture, and the direction of the view in the middle of the row."""

    degrees: dict[str, float]
    joint: str
    seen_from: tuple[float, float, float]
    shows_m: float


_HAND_ON_SHOULDER = next(pose for pose in quality_poses.COMBINED_POSES if "hand" in pose.name)
ROWS = (
    Row({"elbow.L": 120}, "elbow.L", (0.35, -1.0, 0.35), 0.46),
    Row({"knee.L": 120}, "knee.L", (1.0, 0.25, 0.15), 0.62),
    Row({"hip.L": 100}, "hip.L", (1.0, -0.7, 0.2), 0.8),
    Row({"shoulder.L": 110}, "shoulder.L", (0.25, -1.0, 0.1), 0.6),
    Row(_HAND_ON_SHOULDER.degrees, "shoulder.L", (0.1, -1.0, 0.25), 0.95),
)


def render(character: Character, target: Path) -> None:
    """Writes the picture."""
    scene = bpy.data.scenes.new("Turntable")
    skin = demo_picture.material_of("skin", demo_picture.SKIN, 0.42)
    faces = [tuple(face.vertices) for face in character.skin.data.polygons]
    demo_picture.light(scene)
    demo_picture.set_cycles(scene)
    scene.cycles.samples = SAMPLES
    scene.render.resolution_x = scene.render.resolution_y = TILE
    width, height = (count * (TILE + GAP) - GAP for count in (len(TURNS), len(ROWS)))
    whole = np.ones((height, width, 4), np.float32)
    for number, row in enumerate(ROWS):
        character.pose(row.degrees)
        figure = demo_picture.add(
            scene, demo_picture.mesh_of("figure", character.points(SINEW), faces, skin), Matrix.Identity(4)
        )
        bottom = height - TILE - number * (TILE + GAP)
        for column, turn in enumerate(TURNS):
            left = column * (TILE + GAP)
            whole[bottom : bottom + TILE, left : left + TILE] = _tile(scene, character, row, turn)
        bpy.data.objects.remove(figure)
    top_first = (255.0 * whole[::-1, :, :3] + 0.5).astype(np.uint8)
    Image.fromarray(top_first).save(target, optimize=True)


def _tile(scene, character: Character, row: Row, turn: float) -> np.ndarray:
    """(TILE, TILE, 4) float32, the top row last."""
    hinge = quality_poses.hinge_of(character.rig, row.joint)
    middle = character.rig.pose.bones[hinge.bone].head
    seen_from = Matrix.Rotation(math.radians(turn), 3, "Z") @ Vector(row.seen_from).normalized()
    camera = bpy.data.cameras.new("camera")
    camera.type, camera.ortho_scale = "ORTHO", row.shows_m
    matrix = Matrix.Translation(middle + 3.0 * seen_from) @ seen_from.to_track_quat("Z", "Y").to_matrix().to_4x4()
    scene.camera = demo_picture.add(scene, camera, matrix)
    with tempfile.TemporaryDirectory() as folder:
        scene.render.filepath = str(Path(folder, "tile.png"))
        bpy.ops.render.render(write_still=True, scene=scene.name)
        image = bpy.data.images.load(scene.render.filepath)
        pixels = np.empty(TILE * TILE * 4, np.float32)
        image.pixels.foreach_get(pixels)
        bpy.data.images.remove(image)
    return pixels.reshape(TILE, TILE, 4)
