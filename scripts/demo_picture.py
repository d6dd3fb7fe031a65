"""The demo's picture: the body as the Armature modifier alone leaves it, with Sinew, and the muscles that do it.

The figures are plain meshes of the measured points in a scene of their own, rendered with Cycles on the CPU.
"""

import math
from pathlib import Path

import bpy
import numpy as np
from mathutils import Matrix, Vector

WIDTH, HEIGHT = 1400, 800
SAMPLES = 40
SKIN = (0.62, 0.40, 0.31, 1.0)
MUSCLE = (0.50, 0.05, 0.045, 1.0)
BACKGROUND = (0.30, 0.32, 0.35, 1.0)
SPACING_M = 0.95
CAPTIONS = ("Armature modifier alone", "with Sinew", "its muscles")


def render(target: Path, *, faces, before: np.ndarray, after: np.ndarray, ellipsoids: list[np.ndarray]) -> None:
    """Renders the three figures side by side, from the left: before, after, the muscles.

    before, after: (V, 3) float32, world space; ellipsoids: (4, 4) each, the unit sphere to a belly.
    """
    scene = bpy.data.scenes.new("Picture")
    skin, muscle = _material("skin", SKIN, 0.45), _material("muscle", MUSCLE, 0.35)
    glass = _material("see-through skin", SKIN, 0.45, alpha=0.16)
    for place, (points, material) in enumerate(((before, skin), (after, skin), (after, glass))):
        aside = Vector(((place - 1) * SPACING_M, 0.0, 0.0))
        _add(scene, _mesh("figure", points, faces, material), Matrix.Translation(aside))
        _caption(scene, CAPTIONS[place], aside)
    ball = _ball(muscle)
    for ellipsoid in ellipsoids:
        _add(scene, ball, Matrix.Translation(aside) @ Matrix(ellipsoid.tolist()))
    _light(scene)
    _camera(scene)
    _settings(scene, target)
    bpy.ops.render.render(write_still=True, scene=scene.name)


def _mesh(name: str, points: np.ndarray, faces, material):
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata(points.tolist(), [], faces)
    mesh.shade_smooth()
    mesh.materials.append(material)
    return mesh


def _ball(material, rings: int = 24):
    """A unit sphere."""
    mesh = bpy.data.meshes.new("belly")
    turns = np.linspace(0, 2 * math.pi, 2 * rings, endpoint=False)
    rises = np.linspace(-math.pi / 2, math.pi / 2, rings + 1)
    rise, turn = np.meshgrid(rises, turns, indexing="ij")
    points = np.stack([np.cos(rise) * np.cos(turn), np.cos(rise) * np.sin(turn), np.sin(rise)], axis=-1)
    number = np.arange(points.shape[0] * points.shape[1]).reshape(points.shape[:2])
    after = np.roll(number, -1, axis=1)
    faces = np.stack([number[:-1], after[:-1], after[1:], number[1:]], axis=-1).reshape(-1, 4)
    mesh.from_pydata(points.reshape(-1, 3).tolist(), [], faces.tolist())
    mesh.shade_smooth()
    mesh.materials.append(material)
    return mesh


def _add(scene, data, matrix: Matrix):
    added = bpy.data.objects.new(data.name, data)
    added.matrix_world = matrix
    scene.collection.objects.link(added)
    return added


def _material(name: str, colour, roughness: float, alpha: float = 1.0):
    material = bpy.data.materials.new(name)
    material.use_nodes = True
    shader = material.node_tree.nodes["Principled BSDF"]
    shader.inputs["Base Color"].default_value = colour
    shader.inputs["Roughness"].default_value = roughness
    shader.inputs["Alpha"].default_value = alpha
    return material


def _caption(scene, text: str, aside: Vector) -> None:
    curve = bpy.data.curves.new(text, "FONT")
    curve.body, curve.size, curve.align_x = text, 0.07, "CENTER"
    material = bpy.data.materials.new("caption")
    material.use_nodes = True
    material.node_tree.nodes["Principled BSDF"].inputs["Emission Color"].default_value = (1, 1, 1, 1)
    material.node_tree.nodes["Principled BSDF"].inputs["Emission Strength"].default_value = 0.8
    curve.materials.append(material)
    _add(scene, curve, Matrix.Translation(aside + Vector((0, -0.3, -0.13))) @ Matrix.Rotation(math.pi / 2, 4, "X"))


def _light(scene) -> None:
    world = bpy.data.worlds.new("Picture")
    world.use_nodes = True
    world.node_tree.nodes["Background"].inputs["Color"].default_value = BACKGROUND
    scene.world = world
    for name, energy, direction in (("key", 3.2, (-0.9, -0.7, 0.9)), ("rim", 2.0, (1.0, 0.5, 0.5))):
        sun = bpy.data.lights.new(name, "SUN")
        sun.energy, sun.angle = energy, math.radians(8)
        _add(scene, sun, Vector(direction).to_track_quat("Z", "Y").to_matrix().to_4x4())


def _camera(scene) -> None:
    camera = bpy.data.cameras.new("camera")
    camera.type, camera.ortho_scale = "ORTHO", 3.25
    direction = Vector((-0.35, -1.0, 0.12)).normalized()
    placed = Matrix.Translation(Vector((0, 0, 0.83)) + 6 * direction) @ direction.to_track_quat("Z", "Y").to_matrix().to_4x4()
    scene.camera = _add(scene, camera, placed)


def _settings(scene, target: Path) -> None:
    scene.render.engine = "CYCLES"
    scene.cycles.device = "CPU"
    scene.cycles.samples = SAMPLES
    scene.cycles.use_denoising = True
    scene.cycles.max_bounces = 4
    scene.view_settings.view_transform = "Standard"
    scene.render.resolution_x, scene.render.resolution_y, scene.render.resolution_percentage = WIDTH, HEIGHT, 100
    scene.render.image_settings.file_format = "PNG"
    scene.render.filepath = str(target)
