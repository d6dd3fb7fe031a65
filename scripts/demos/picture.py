"""Renders the demo's picture: the muscles, and arm and leg with the Armature modifier alone and with Sinew.

The figures are plain meshes of the measured points in a separate scene. Cycles renders each panel on the CPU, and the panels
are joined into one picture.
"""

import math
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import bpy
import numpy as np
from mathutils import Matrix, Vector

HEIGHT, GAP = 800, 4
SAMPLES = 32
SKIN = (0.60, 0.37, 0.28, 1.0)
MUSCLE = (0.45, 0.03, 0.03, 1.0)
BACKGROUND = (0.16, 0.175, 0.20, 1.0)
APART_M = 10.0  # so that a panel shows only one figure


@dataclass(frozen=True)
class Panel:
    """A part of the picture: its position in pixels from the left and the top, and the view of a figure in it."""

    caption: str
    figure: int
    left: int
    top: int
    width: int
    height: int
    centre: tuple[float, float, float]
    seen_from: tuple[float, float, float]
    shows_m: float  # over the longer side

    @property
    def longer(self) -> int:
        return max(self.width, self.height)


BEFORE, AFTER, MUSCLES = range(3)
FULL, HALF, ROW = 492, 450, (HEIGHT - GAP) // 2
ARM = (0.33, 0.0, 1.44), (0.12, -1.0, -0.05), 0.42
LEG = (0.13, -0.19, 0.73), (1.0, -0.45, 0.1), 0.72
PANELS = (
    Panel("the muscles", MUSCLES, 0, 0, FULL, HEIGHT, (0.0, 0.0, 0.92), (-0.3, -1.0, 0.08), 1.98),
    Panel("Armature modifier alone", BEFORE, FULL + GAP, 0, HALF, ROW, *ARM),
    Panel("with Sinew", AFTER, FULL + HALF + 2 * GAP, 0, HALF, ROW, *ARM),
    Panel("Armature modifier alone", BEFORE, FULL + GAP, ROW + GAP, HALF, ROW, *LEG),
    Panel("with Sinew", AFTER, FULL + HALF + 2 * GAP, ROW + GAP, HALF, ROW, *LEG),
)


def render(target: Path, *, faces, before: np.ndarray, after: np.ndarray, ellipsoids: list[np.ndarray]) -> None:
    """Writes the picture.

    before, after: (V, 3) float32, world space. ellipsoids: (4, 4) each, the matrix from the unit sphere to a belly.
    """
    scene = bpy.data.scenes.new("Picture")
    skin = material_of("skin", SKIN, 0.42)
    for figure, points, material in ((BEFORE, before, skin), (AFTER, after, skin), (MUSCLES, after, _glass())):
        add(scene, mesh_of("figure", points, faces, material), matrix_of(figure))
    belly = unit_ball(material_of("muscle", MUSCLE, 0.35))
    for ellipsoid in ellipsoids:
        add(scene, belly, matrix_of(MUSCLES) @ Matrix(ellipsoid.tolist()))
    light(scene)
    set_cycles(scene)
    _render_panels(scene, PANELS, target)


def render_figures(target: Path, *, faces, figures: list[np.ndarray], panels: Sequence[Panel]) -> None:
    """Writes a picture of several figures, each (V, 3) float32, world space, in the given panels."""
    scene = bpy.data.scenes.new("Picture")
    skin = material_of("skin", SKIN, 0.42)
    for figure, points in enumerate(figures):
        add(scene, mesh_of("figure", points, faces, skin), matrix_of(figure))
    light(scene)
    set_cycles(scene)
    _render_panels(scene, panels, target)


def _render_panels(scene, panels: Sequence[Panel], target: Path) -> None:
    with tempfile.TemporaryDirectory() as folder:
        join(panels, [render_panel(scene, panel, Path(folder, f"{i}.png")) for i, panel in enumerate(panels)], target)


def matrix_of(figure: int) -> Matrix:
    return Matrix.Translation((APART_M * figure, 0.0, 0.0))


def render_panel(scene, panel: Panel, file: Path) -> np.ndarray:
    """(height, width, 4) float32: the rendered panel, with the top row last."""
    data = bpy.data.cameras.new("camera")
    data.type, data.ortho_scale = "ORTHO", panel.shows_m
    seen_from = Vector(panel.seen_from).normalized()
    middle = matrix_of(panel.figure) @ Vector(panel.centre)
    scene.camera = add(
        scene, data, Matrix.Translation(middle + 3.0 * seen_from) @ seen_from.to_track_quat("Z", "Y").to_matrix().to_4x4()
    )
    caption = _caption(scene, panel)
    scene.render.resolution_x, scene.render.resolution_y = panel.width, panel.height
    scene.render.filepath = str(file)
    bpy.ops.render.render(write_still=True, scene=scene.name)
    bpy.data.objects.remove(caption)
    image = bpy.data.images.load(str(file))
    pixels = np.empty(panel.width * panel.height * 4, np.float32)
    image.pixels.foreach_get(pixels)
    bpy.data.images.remove(image)
    return pixels.reshape(panel.height, panel.width, 4)


def _caption(scene, panel: Panel):
    """A text at the lower edge of the panel, facing the camera."""
    metres_per_pixel = panel.shows_m / panel.longer
    curve = bpy.data.curves.new("caption", "FONT")
    curve.body, curve.size, curve.align_x = panel.caption, 26 * metres_per_pixel, "CENTER"
    curve.materials.append(_glow())
    matrix = Matrix.Translation((0.0, -(panel.height / 2 - 16) * metres_per_pixel, -1.0))
    return add(scene, curve, scene.camera.matrix_world @ matrix)


def join(panels: Sequence[Panel], images: list[np.ndarray], target: Path) -> None:
    width, height = (
        max(ends) for ends in zip(*((each.left + each.width, each.top + each.height) for each in panels), strict=True)
    )
    whole = np.ones((height, width, 4), np.float32)
    for panel, pixels in zip(panels, images, strict=True):
        bottom = height - panel.top - panel.height
        whole[bottom : bottom + panel.height, panel.left : panel.left + panel.width] = pixels
    image = bpy.data.images.new("demo", width, height)
    image.pixels.foreach_set(whole.reshape(-1))
    image.file_format, image.filepath_raw = "PNG", str(target)
    image.save()


def mesh_of(name: str, points: np.ndarray, faces, material):
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata(points.tolist(), [], faces)
    mesh.shade_smooth()
    mesh.materials.append(material)
    return mesh


def unit_ball(material, rings: int = 24):
    """A mesh of a unit sphere."""
    angles = np.linspace(0, 2 * math.pi, 2 * rings, endpoint=False)
    latitude, longitude = np.meshgrid(np.linspace(-math.pi / 2, math.pi / 2, rings + 1), angles, indexing="ij")
    points = np.stack(
        [np.cos(latitude) * np.cos(longitude), np.cos(latitude) * np.sin(longitude), np.sin(latitude)], axis=-1
    )
    number = np.arange(latitude.size).reshape(latitude.shape)
    beside = np.roll(number, -1, axis=1)
    faces = np.stack([number[:-1], beside[:-1], beside[1:], number[1:]], axis=-1)
    return mesh_of("belly", points.reshape(-1, 3), faces.reshape(-1, 4).tolist(), material)


def add(scene, data, matrix: Matrix):
    added = bpy.data.objects.new(data.name, data)
    added.matrix_world = matrix
    scene.collection.objects.link(added)
    return added


def material_of(name: str, colour, roughness: float):
    material = bpy.data.materials.new(name)
    shader = material.node_tree.nodes["Principled BSDF"]
    shader.inputs["Base Color"].default_value = colour
    shader.inputs["Roughness"].default_value = roughness
    return material


def _glass():
    """A skin material that is visible only where it faces away from the camera."""
    material = material_of("see-through skin", SKIN, 0.5)
    nodes, links = material.node_tree.nodes, material.node_tree.links
    facing, alpha = nodes.new("ShaderNodeLayerWeight"), nodes.new("ShaderNodeMath")
    alpha.operation, alpha.inputs[1].default_value = "MULTIPLY_ADD", 0.30
    alpha.inputs[2].default_value = 0.04
    links.new(facing.outputs["Facing"], alpha.inputs[0])
    links.new(alpha.outputs[0], nodes["Principled BSDF"].inputs["Alpha"])
    return material


def _glow():
    material = material_of("caption", (0, 0, 0, 1), 1.0)
    shader = material.node_tree.nodes["Principled BSDF"]
    shader.inputs["Emission Color"].default_value = (1, 1, 1, 1)
    shader.inputs["Emission Strength"].default_value = 0.8
    return material


def light(scene) -> None:
    world = bpy.data.worlds.new("Picture")
    world.node_tree.nodes["Background"].inputs["Color"].default_value = BACKGROUND
    scene.world = world
    for name, energy, direction in (("key", 3.8, (-0.45, -0.4, 1.0)), ("rim", 1.4, (1.0, 0.3, 0.1))):
        sun = bpy.data.lights.new(name, "SUN")
        sun.energy, sun.angle = energy, math.radians(6)
        add(scene, sun, Vector(direction).to_track_quat("Z", "Y").to_matrix().to_4x4())


def set_cycles(scene) -> None:
    scene.render.engine = "CYCLES"
    scene.cycles.device = "CPU"
    scene.cycles.samples = SAMPLES
    scene.cycles.use_denoising = True
    scene.cycles.max_bounces = 4
    scene.view_settings.view_transform = "Standard"
    scene.render.resolution_percentage = 100
    scene.render.image_settings.file_format = "PNG"
