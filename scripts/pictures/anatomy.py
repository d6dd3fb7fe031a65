"""Renders the presets for docs/ as ellipsoids in a translucent body: human_front.png, human_back.png, cat.png.

usage: python3 scripts/run_in_blender.py scripts/pictures/anatomy.py [PICTURE...] [--out FOLDER] [--preset NAME]

The human is the MakeHuman body with the preset fitted under it; the cat is Rigify's metarig, which has no skin.
"""

import argparse
import colorsys
import math
from pathlib import Path

import bpy
import addon_utils
from bl_ext.user_default.sinew.muscles.placing.fit import fit
from bl_ext.user_default.sinew.muscles.placing.fit.skin_surface import SkinSurface
from bl_ext.user_default.sinew.muscles.placing.place import placement, preset_file
from bl_ext.user_default.sinew.muscles.placing.recognise import segments
from build.layout import ROOT
from mathutils import Matrix, Vector

# picture: body, direction of the view, middle and height of the view in m, size in pixels
PICTURES = {
    "human_front": ("human", (0, -1, 0), (0, 0, 0.87), 1.8, (620, 900)),
    "human_back": ("human", (0, 1, 0), (0, 0, 0.87), 1.8, (620, 900)),
    "cat": ("cat", (1, -0.25, 0.12), (0, 0.1, 0.16), 0.92, (1000, 520)),
    "trunk_front": ("human", (0.1, -1, 0.1), (0, 0, 1.25), 0.85, (900, 900)),
    "trunk_back": ("human", (0.2, 1, 0.1), (0, 0, 1.25), 0.85, (900, 900)),
    "trunk_side": ("human", (1, -0.2, 0.1), (0.1, 0, 1.2), 0.95, (900, 900)),
    "legs_front": ("human", (0.3, -1, 0), (0, 0, 0.5), 1.1, (700, 900)),
    "legs_back": ("human", (0.3, 1, 0), (0, 0, 0.5), 1.1, (700, 900)),
    "cat_front": ("cat", (0.5, -1, 0.25), (0, -0.1, 0.16), 0.5, (800, 700)),
    "cat_close": ("cat", (1, -0.1, 0.05), (0, -0.02, 0.15), 0.5, (1100, 700)),
}
PUBLISHED = ("human_front", "human_back", "cat")
BONE_COLOUR, STUFFING_COLOUR = (0.80, 0.76, 0.64), (0.72, 0.60, 0.50)
TENDON_COLOUR = (0.85, 0.82, 0.75)
TENDON_RADIUS_OF_BELLY = 0.18
SAMPLES = 40


def shapes_of(body: str, preset_name: str):
    """Tissues fitted to a body in a new file, and the skin, or None."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    preset = preset_file.read(preset_name)
    if body == "cat":
        addon_utils.enable("rigify", default_set=True)
        bpy.ops.object.armature_cat_metarig_add()
        return placement.place(preset, segments.recognise(bpy.context.object), None), None
    from data import body_in_blender

    mesh, rig = body_in_blender.build()
    skin = SkinSurface.of(mesh, rig)
    return fit.fit_all(placement.place(preset, segments.recognise(rig), skin), skin), mesh


def draw(shapes, skin) -> None:
    """Replaces the contents of the scene with the ellipsoids and the translucent skin."""
    scene = bpy.context.scene
    for found in list(scene.objects):
        if found != skin:
            bpy.data.objects.remove(found)
    ball = _ball()
    names = list(dict.fromkeys(shape.name.rpartition(".")[0] or shape.name for shape in shapes))
    for shape in shapes:
        if shape.kind == "SPHERE":
            continue
        if shape.kind == "STUFFING" and skin is None:  # it represents the missing body
            made = _ellipsoid(ball, Matrix.LocRotScale(shape.centre, shape.rotation, shape.semi_axes), STUFFING_COLOUR)
            made.data.materials[0] = _glass()
            continue
        colour = {"BONE": BONE_COLOUR, "STUFFING": STUFFING_COLOUR}.get(shape.kind)
        if colour is None:
            number = names.index(shape.name.rpartition(".")[0] or shape.name)
            colour = colorsys.hsv_to_rgb(
                (0.985 + 0.04 * ((number * 0.381) % 1.0)) % 1.0, 0.85, 0.3 + 0.35 * ((number * 0.618) % 1)
            )
        _ellipsoid(ball, Matrix.LocRotScale(shape.centre, shape.rotation, shape.semi_axes), colour)
        if shape.kind == "MUSCLE":
            axis = shape.rotation @ Vector((0, 0, shape.semi_axes.z))
            for outer, end in ((shape.origin, shape.centre - axis), (shape.insertion, shape.centre + axis)):
                _tendon(ball, outer, end, TENDON_RADIUS_OF_BELLY * shape.semi_axes.x)
    if skin:
        skin.modifiers.clear()
        skin.data.materials.clear()
        skin.data.materials.append(_glass())


def _ball() -> bpy.types.Mesh:
    bpy.ops.mesh.primitive_uv_sphere_add(segments=32, ring_count=20)
    ball = bpy.context.object
    mesh = ball.data
    mesh.shade_smooth()
    bpy.data.objects.remove(ball)
    return mesh


def _ellipsoid(ball, matrix: Matrix, colour) -> bpy.types.Object:
    made = bpy.data.objects.new("Tissue", ball.copy())
    made.data.materials.append(_material(colour))
    bpy.context.scene.collection.objects.link(made)
    made.matrix_world = matrix
    return made


def _tendon(ball, outer: Vector, end: Vector, radius_m: float) -> None:
    length_m = (outer - end).length
    if length_m > 1e-3:
        rotation = (outer - end).to_track_quat("Z", "Y")
        _ellipsoid(
            ball,
            Matrix.LocRotScale((outer + end) / 2, rotation, Vector((radius_m, radius_m, length_m * 0.6))),
            TENDON_COLOUR,
        )


def _material(colour) -> bpy.types.Material:
    name = "{:.3f} {:.3f} {:.3f}".format(*colour)
    material = bpy.data.materials.get(name)
    if material is None:
        material = bpy.data.materials.new(name)
        material.use_nodes = True
        shader = material.node_tree.nodes["Principled BSDF"]
        shader.inputs["Base Color"].default_value = (*colour, 1.0)
        shader.inputs["Roughness"].default_value = 0.5
    return material


def _glass() -> bpy.types.Material:
    """A material that is clear where it faces the camera, and denser toward the outline."""
    material = bpy.data.materials.new("Skin")
    material.use_nodes = True
    tree = material.node_tree
    shader = tree.nodes["Principled BSDF"]
    shader.inputs["Base Color"].default_value = (0.3, 0.25, 0.25, 1.0)
    shader.inputs["Roughness"].default_value = 0.8
    facing, weaker = tree.nodes.new("ShaderNodeLayerWeight"), tree.nodes.new("ShaderNodeMath")
    facing.inputs[0].default_value = 0.25
    weaker.operation, weaker.inputs[1].default_value = "MULTIPLY", 0.4
    tree.links.new(facing.outputs["Facing"], weaker.inputs[0])
    tree.links.new(weaker.outputs[0], shader.inputs["Alpha"])
    return material


def render(view: Vector, target: Vector, height_m: float, pixels: tuple[int, int], path: Path) -> None:
    """Renders one orthographic picture, with Cycles on the CPU."""
    scene = bpy.context.scene
    world = scene.world = bpy.data.worlds.new("World")
    world.use_nodes = True
    world.node_tree.nodes["Background"].inputs[0].default_value = (0.93, 0.93, 0.95, 1.0)
    world.node_tree.nodes["Background"].inputs[1].default_value = 0.6
    sun = bpy.data.objects.new("Sun", bpy.data.lights.new("Sun", "SUN"))
    sun.data.energy = 2.5
    camera = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
    camera.data.type, camera.data.ortho_scale = "ORTHO", height_m
    for added in (sun, camera):
        scene.collection.objects.link(added)
    scene.camera = camera
    rotation = view.to_track_quat("Z", "Y")
    camera.location, camera.rotation_euler = target + view * 3, rotation.to_euler()
    sun.rotation_euler = (view + rotation @ Vector((0.5, 0.7, 0))).to_track_quat("Z", "Y").to_euler()
    scene.render.engine = "CYCLES"
    scene.cycles.samples, scene.cycles.use_denoising = SAMPLES, True
    scene.cycles.max_bounces, scene.cycles.transparent_max_bounces = 2, 16
    scene.render.threads_mode, scene.render.threads = "FIXED", 2
    scene.view_settings.view_transform = "Standard"
    scene.render.resolution_x, scene.render.resolution_y = pixels
    scene.render.image_settings.color_mode, scene.render.image_settings.compression = "RGB", 100
    scene.render.filepath = str(path)
    bpy.ops.render.render(write_still=True)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("pictures", nargs="*", default=PUBLISHED)
    parser.add_argument("--out", type=Path, default=ROOT / "docs")
    parser.add_argument("--preset")
    wanted = parser.parse_args()
    wanted.out.mkdir(parents=True, exist_ok=True)
    for name in wanted.pictures:
        body, view, target, height_m, pixels = PICTURES[name]
        draw(*shapes_of(body, wanted.preset or body))
        path = wanted.out / f"{name}.png"
        render(Vector(view).normalized(), Vector(target), height_m, pixels, path)
        print(f"{path}: {math.ceil(path.stat().st_size / 1000)} kB")


if __name__ == "__main__":
    main()
