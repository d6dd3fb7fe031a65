"""Renders the presets for docs/ as ellipsoids in a translucent body: human_front.png, human_back.png, cat.png,
and a turntable of four figures, with and without skin.

usage: python3 scripts/run_in_blender.py scripts/pictures/anatomy.py [PICTURE...] [--out FOLDER] [--preset NAME]

The human is the MakeHuman body with the preset fitted under it; the cat is Rigify's metarig, which has no skin.
"""

import argparse
import colorsys
import math
from pathlib import Path

import bpy
import addon_utils
from bl_ext.user_default.sinew.live import attachments, ellipsoids, session
from bl_ext.user_default.sinew.muscles import portable_names
from bl_ext.user_default.sinew.muscles.placing.place import preset_file
from bl_ext.user_default.sinew.muscles.placing.place.preset_to_rig import populate
from bl_ext.user_default.sinew.muscles.placing.recognise import segments
from bl_ext.user_default.sinew.scene import characters
from build.layout import ROOT
from data import anny_body, body_in_blender
from mathutils import Matrix, Vector

# picture: body, direction of the view, middle and height of the view in m, size in pixels
PICTURES = {
    **{f"turntable_{figure}": (figure, (0, -1, 0), (0, 0, 0), 0.0, (1800, 520)) for figure in anny_body.TARGETS},
    "human_front": ("male", (0, -1, 0), (0, 0, 0.87), 1.8, (620, 900)),
    "human_back": ("male", (0, 1, 0), (0, 0, 0.87), 1.8, (620, 900)),
    "cat": ("cat", (1, -0.25, 0.12), (0, 0.1, 0.16), 0.92, (1000, 520)),
    "trunk_front": ("male", (0.1, -1, 0.1), (0, 0, 1.25), 0.85, (900, 900)),
    "trunk_back": ("male", (0.2, 1, 0.1), (0, 0, 1.25), 0.85, (900, 900)),
    "trunk_side": ("male", (1, -0.2, 0.1), (0.1, 0, 1.2), 0.95, (900, 900)),
    "legs_front": ("male", (0.3, -1, 0), (0, 0, 0.5), 1.1, (700, 900)),
    "legs_back": ("male", (0.3, 1, 0), (0, 0, 0.5), 1.1, (700, 900)),
    "cat_front": ("cat", (0.5, -1, 0.25), (0, -0.1, 0.16), 0.5, (800, 700)),
    "cat_close": ("cat", (1, -0.1, 0.05), (0, -0.02, 0.15), 0.5, (1100, 700)),
}
TURNTABLE = "turntable_"
PUBLISHED = ("human_front", "human_back", "cat", *(f"{TURNTABLE}{figure}" for figure in anny_body.TARGETS))
APART_OF_HEIGHT = 0.62  # distance of the views of a turntable, over the body's height
MARGIN = 1.02
SKIN_COLOUR = (0.62, 0.42, 0.33)
BONE_COLOUR, STUFFING_COLOUR = (0.80, 0.76, 0.64), (0.72, 0.60, 0.50)
TENDON_COLOUR = (0.85, 0.82, 0.75)
FAT = "fat pads"  # the group of tissues that are not shown
SAMPLES = 40


def rig_of(body: str, preset_name: str):
    """A body with the tissues of a preset in a new file: the rig, and the skin, or None."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    preset = preset_file.read(preset_name)
    if body == "cat":
        addon_utils.enable("rigify", default_set=True)
        bpy.ops.object.armature_cat_metarig_add()
        rig = bpy.context.object
        populate(rig, preset, segments.recognise(rig), [])
        return rig, None
    mesh, rig = body_in_blender.build(body)
    populate(rig, preset, segments.recognise(rig), [mesh])
    return rig, mesh


def draw(rig, skin, offset: tuple[float, float, float] = (0, 0, 0), turn: float = 0.0) -> None:
    """Adds the ellipsoids and tendons of a rig to the scene, turned about the vertical and moved."""
    bpy.context.view_layer.update()
    state = session.cached_rig(rig)
    found = ellipsoids.of(state)
    solved = [characters.tissues_of(rig)[index] for index in state.solved]
    place = Matrix.Translation(Vector(offset)) @ Matrix.Rotation(turn, 4, "Z")
    ball = _ball()
    fat = {rule.name for rule in preset_file.read("human").tissues if rule.group == FAT}  # as on an anatomical plate
    names = list(dict.fromkeys(portable_names.without_side(empty.name) for empty in solved))
    for matrix, owner in zip(found.matrices, found.owners):
        empty = solved[owner]
        kind = empty.sinew.tissue.kind
        if kind == "SPHERE" or portable_names.without_side(empty.name) in fat:
            continue
        matrix = place @ Matrix(matrix.T)
        if kind == "STUFFING" and skin is None:  # it represents the missing body
            made = _ellipsoid(ball, matrix, STUFFING_COLOUR)
            made.data = made.data.copy()
            made.data.materials[0] = _glass()
            continue
        colour = {"BONE": BONE_COLOUR, "STUFFING": STUFFING_COLOUR}.get(kind)
        if colour is None:
            number = names.index(portable_names.without_side(empty.name))
            colour = colorsys.hsv_to_rgb(
                (0.985 + 0.04 * ((number * 0.381) % 1.0)) % 1.0, 0.85, 0.3 + 0.35 * ((number * 0.618) % 1)
            )
        _ellipsoid(ball, matrix, colour)
    for matrix in attachments.tendons_of(rig, state):
        _ellipsoid(ball, place @ Matrix(matrix.T), TENDON_COLOUR)


def draw_turntable(rig, skin, height_m: float) -> None:
    """Adds three views of the tissues side by side, front, side and back, and beside them the same of the skin."""
    apart = APART_OF_HEIGHT * height_m
    for number, turn in enumerate((0.0, -math.pi / 2, math.pi)):
        draw(rig, skin, (apart * (number - 2.5), 0, 0), turn)
        copy = bpy.data.objects.new("View", skin.data)
        bpy.context.scene.collection.objects.link(copy)
        copy.matrix_world = Matrix.Translation((apart * (number + 0.5), 0, 0)) @ Matrix.Rotation(turn, 4, "Z")
    skin.data.materials.clear()
    skin.data.materials.append(_material(SKIN_COLOUR))


def _ball() -> bpy.types.Mesh:
    bpy.ops.mesh.primitive_uv_sphere_add(segments=32, ring_count=20)
    ball = bpy.context.object
    mesh = ball.data
    mesh.shade_smooth()
    bpy.data.objects.remove(ball)
    return mesh


def _ellipsoid(ball, matrix: Matrix, colour) -> bpy.types.Object:
    name = "Ellipsoid {:.3f} {:.3f} {:.3f}".format(*colour)
    mesh = bpy.data.meshes.get(name)
    if mesh is None:
        mesh = ball.copy()
        mesh.name = name
        mesh.materials.append(_material(colour))
    made = bpy.data.objects.new("Tissue", mesh)
    bpy.context.scene.collection.objects.link(made)
    made.matrix_world = matrix
    return made


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
        preset = wanted.preset or ("cat" if body == "cat" else "human")
        rig, skin = rig_of(body, preset)
        present = list(bpy.context.scene.objects)
        if name.startswith(TURNTABLE):
            tall_m = skin.dimensions.z
            target, height_m = (0, 0, tall_m / 2), MARGIN * 6 * APART_OF_HEIGHT * tall_m
            draw_turntable(rig, skin, tall_m)
        else:
            draw(rig, skin)
            if skin:
                skin.modifiers.clear()
                skin.data.materials.clear()
                skin.data.materials.append(_glass())
        for old in present:
            if old != skin or name.startswith(TURNTABLE):
                bpy.data.objects.remove(old)
        path = wanted.out / f"{name}.png"
        render(Vector(view).normalized(), Vector(target), height_m, pixels, path)
        print(f"{path}: {math.ceil(path.stat().st_size / 1000)} kB")


if __name__ == "__main__":
    main()
