# SPDX-License-Identifier: GPL-3.0-or-later
"""Writes the .blend files of Sinew 0.1 that test_migration.py opens, with the points that 0.1 showed.

usage, once in each Blender, from a checkout of Sinew 0.1 (commit 8ae8675):
    python3 scripts/run_in_blender.py --blender 4.5 /path/to/tests/blender/files/make_files.py FOLDER

Later versions of Sinew can't make these files: that is what they are for. FOLDER receives
    arm_0.1_blender_VERSION.blend      a character with every setting that a user could make
    library_0.1_blender_VERSION.blend  a character in the collection "Character"
    shot_0.1_blender_VERSION.blend     that character, linked and overridden, with overridden settings
    shown_0.1_blender_VERSION.npz      the points of the meshes as 0.1 showed them, in the frames of the keyword names
"""

import math
import sys
from pathlib import Path

import bpy
import numpy as np

FRAMES = (1, 6, 12)
VERSION = "{}.{}".format(*bpy.app.version)


def make_arm(name="Arm", rings=24, around=20, radius=0.05):
    """(mesh object, armature object): a round arm of two bones, 0.6 m along X."""
    armature = bpy.data.armatures.new(f"{name} Rig")
    rig = bpy.data.objects.new(f"{name} Rig", armature)
    bpy.context.scene.collection.objects.link(rig)
    bpy.context.view_layer.objects.active = rig
    bpy.ops.object.mode_set(mode="EDIT")
    upper, lower = armature.edit_bones.new("upper"), armature.edit_bones.new("lower")
    upper.head, upper.tail = (0, 0, 0), (0.3, 0, 0)
    lower.head, lower.tail = (0.3, 0, 0), (0.6, 0, 0)
    lower.parent = upper
    bpy.ops.object.mode_set(mode="OBJECT")
    return make_tube(rig, name, rings, around, radius), rig


def make_tube(rig, name, rings, around, radius):
    along = np.linspace(0.0, 0.6, rings)
    angle = np.linspace(0.0, 2.0 * np.pi, around, endpoint=False)
    points = [(x, radius * np.cos(a), radius * np.sin(a)) for x in along for a in angle]
    faces = [
        (r * around + a, r * around + (a + 1) % around, (r + 1) * around + (a + 1) % around, (r + 1) * around + a)
        for r in range(rings - 1)
        for a in range(around)
    ]
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata(points, [], faces)
    skin = bpy.data.objects.new(name, mesh)
    bpy.context.scene.collection.objects.link(skin)
    for bone, sign in (("upper", -1.0), ("lower", 1.0)):
        group = skin.vertex_groups.new(name=bone)
        for index, (x, _y, _z) in enumerate(points):
            weight = min(max(0.5 + sign * (x - 0.3) / 0.12, 0.0), 1.0)
            if weight:
                group.add([index], weight, "REPLACE")
    skin.parent = rig
    skin.modifiers.new("Armature", "ARMATURE").object = rig
    return skin


def select(*objects):
    for found in bpy.context.view_layer.objects:
        found.select_set(False)
    for found in objects:
        found.select_set(True)
    bpy.context.view_layer.objects.active = objects[0]


def add_tissue(rig, name, **settings):
    select(rig)
    before = set(bpy.data.objects)
    bpy.ops.sinew.add_tissue(**settings)
    empty = (set(bpy.data.objects) - before).pop()
    empty.name = name
    return empty


def add_muscle(rig, name, around):
    return add_tissue(rig, name, kind="MUSCLE", origin_bone="upper", insertion_bone="lower", around=around)


def bind(skin):
    select(skin)
    bpy.ops.sinew.bind()


def key_bend(rig):
    bone = rig.pose.bones["lower"]
    bone.rotation_mode = "XYZ"
    for frame, angle in ((1, 0.0), (12, 1.4)):
        bone.rotation_euler[2] = angle
        bone.keyframe_insert("rotation_euler", frame=frame)


def make_character():
    skin, rig = make_arm()
    flexor = add_muscle(rig, "Flexor", -math.pi / 2)
    extensor = add_muscle(rig, "Extensor", math.pi / 2)
    sphere = add_tissue(rig, "Ball", kind="SPHERE", origin_bone="lower")
    add_tissue(rig, "Shaft", kind="BONE", origin_bone="upper")
    key_bend(rig)
    bind(skin)
    tissues = {"origin_tendon": 0.03, "insertion_tendon": 0.02, "volume_keeping": 0.75, "skin_thickness": 0.0078125}
    for name, value in tissues.items():
        setattr(flexor.sinew, name, value)
    extensor.sinew.wraps.add().sphere = sphere
    add_via(rig, extensor)
    for frame, tension in ((1, 0.0), (12, 1.0)):
        flexor.sinew.tension = tension
        flexor.sinew.keyframe_insert("tension", frame=frame)
    # the tension of this one is in a strip of its NLA
    for frame, tension in ((1, 1.0), (12, 0.25)):
        extensor.sinew.tension = tension
        extensor.sinew.keyframe_insert("tension", frame=frame)
    action = extensor.animation_data.action
    extensor.animation_data.nla_tracks.new().strips.new("tense", 1, action)
    extensor.animation_data.action = None
    set_skin(skin, rig)
    add_goal(rig)
    make_grown(rig)
    rig.sinew.mirror_x, rig.sinew.show_attachments, rig.sinew.show_bones = True, True, False
    rig.sinew.show_spheres = False  # puts the sphere away
    rig.sinew.show_shaded = True
    collection = bpy.data.collections.new("Arm Rig Export")
    rig.sinew.export_copy = collection
    collection.use_fake_user = True


def add_via(rig, muscle):
    select(muscle)
    bpy.ops.sinew.add_via_point()
    via = next(found for found in bpy.data.objects if found.sinew.kind == "VIA")
    via.name = "Extensor via"
    via.sinew.order = 3


def set_skin(skin, rig):
    own = skin.sinew
    own.carry, own.scale_fat, own.reach = "FULL", True, 0.0625
    own.iterations, own.anchor_stiffness, own.edge_stiffness = 8, 0.75, 1.5
    own.rest_distance, own.fat_sliding, own.collides, own.contacts = 0.015625, 0.25, True, False
    curve = own.driver_add("gain")
    variable = curve.driver.variables.new()
    variable.name, variable.type = "switch", "SINGLE_PROP"
    variable.targets[0].id, variable.targets[0].data_path = bpy.data.objects["Flexor"], "sinew.volume_keeping"
    curve.driver.expression = "2.0 * switch"
    lower = rig.pose.bones["lower"].sinew
    lower.multiplier, lower.rest_distance, lower.anchor_stiffness, lower.crease = 0.5, 2.0, 1.25, 0.75
    rig.keyframe_insert('pose.bones["lower"].sinew.rest_distance', frame=1)
    factors = np.linspace(0.0, 2.0, len(skin.data.vertices), dtype=np.float32)
    skin.data.attributes.new("sinew_rest_distance", "FLOAT", "POINT").data.foreach_set("value", factors)
    # the report of a measurement, as the operator writes it
    own.quality_text = bpy.data.texts.new("Arm Quality")
    own.quality_summary, own.corrective_summary, own.cache_modifier = "stretch 1.25", "lower: 2 keys", 0


def add_goal(rig):
    empty = bpy.data.objects.new("Hand Goal", None)
    bpy.context.scene.collection.objects.link(empty)
    goal = empty.sinew.goal
    goal.rig, goal.bone, goal.at_tail, goal.chain_length = rig, "lower", False, 2
    goal.position_weight, goal.orientation_weight, goal.look_at_weight, goal.look_axis = 0.5, 0.25, 0.125, "-Z"
    goal.keyframe_insert("position_weight", frame=3)


def make_grown(rig):
    grown = make_tube(rig, "Grown", 8, 6, 0.055)
    group = grown.vertex_groups.new(name="sinew_rest_distance")
    group.add(range(len(grown.data.vertices)), 0.5, "REPLACE")
    bind(grown)
    growth = grown.sinew.growth
    growth.is_grown, growth.resolution, growth.thickness, growth.faces, growth.symmetric = True, 48, 0.0078125, 400, False
    grown.sinew.anchoring, grown.sinew.energy = "NEAREST", "SPRINGS"
    select(grown)
    for prefix in ("walk", "run"):
        grown.sinew.live = True
        bpy.ops.sinew.bake_shape_keys(frame_start=1, frame_end=12, step=6, tolerance=0.0, prefix=prefix)
    return grown


def points_of(name):
    mesh = bpy.data.objects[name].evaluated_get(bpy.context.evaluated_depsgraph_get()).data
    points = np.empty(len(mesh.vertices) * 3, np.float32)
    mesh.vertices.foreach_get("co", points)
    return points.reshape(-1, 3)


def shown(names):
    """The points of each mesh in each frame, as the file shows them when it is opened."""
    found = {}
    for frame in FRAMES:
        bpy.context.scene.frame_set(frame)
        bpy.context.view_layer.update()
        found |= {f"{name}_{frame}": points_of(name) for name in names}
    return found


def save(path):
    bpy.context.scene.frame_set(1)
    for screen in bpy.data.screens:
        screen.use_fake_user = False
    bpy.ops.wm.save_as_mainfile(filepath=str(path), compress=True)


def make_library(path):
    skin, rig = make_arm(rings=12, around=8)
    flexor = add_muscle(rig, "Flexor", -math.pi / 2)
    sphere = add_tissue(rig, "Ball", kind="SPHERE", origin_bone="lower")
    extensor = add_muscle(rig, "Extensor", math.pi / 2)
    extensor.sinew.wraps.add().sphere = sphere
    add_via(rig, extensor)
    key_bend(rig)
    bind(skin)
    skin.sinew.carry, skin.sinew.gain, flexor.sinew.tension = "FULL", 1.5, 0.25
    rig.pose.bones["upper"].sinew.multiplier = 0.5
    rig.pose.bones["lower"].sinew.rest_distance = 0.5
    collection = bpy.data.collections.new("Character")
    bpy.context.scene.collection.children.link(collection)
    for found in bpy.data.objects:
        for other in found.users_collection:
            other.objects.unlink(found)
        collection.objects.link(found)
    save(path)


def make_shot(path, library):
    with bpy.data.libraries.load(str(library), link=True, relative=True) as (_source, target):
        target.collections = ["Character"]
    made = target.collections[0].override_hierarchy_create(bpy.context.scene, bpy.context.view_layer)
    objects = {found.name: found for found in made.all_objects}
    skin, rig, flexor = objects["Arm"], objects["Arm Rig"], objects["Flexor"]
    skin.sinew.gain, skin.sinew.reach, skin.sinew.energy, skin.sinew.elastic = 2.5, 0.0625, "SPRINGS", True
    flexor.sinew.tension, flexor.sinew.volume_keeping = 0.75, 0.5
    rig.sinew.show_bones, rig.sinew.mirror_x = False, True
    lower = rig.pose.bones["lower"].sinew
    lower.multiplier, lower.rest_distance = 0.25, 1.5
    save(path)


def main(folder: Path):
    folder.mkdir(parents=True, exist_ok=True)
    files = {kind: folder / f"{kind}_0.1_blender_{VERSION}.blend" for kind in ("arm", "library", "shot")}
    bpy.ops.wm.read_factory_settings(use_empty=True)
    make_character()
    save(files["arm"])
    bpy.ops.wm.open_mainfile(filepath=str(files["arm"]))
    points = shown(("Arm", "Grown"))
    bpy.ops.wm.read_factory_settings(use_empty=True)
    make_library(files["library"])
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.ops.wm.save_as_mainfile(filepath=str(files["shot"]), compress=True)  # so that the library's path is relative
    make_shot(files["shot"], files["library"])
    bpy.ops.wm.open_mainfile(filepath=str(files["shot"]))
    override = next(found for found in bpy.data.objects if found.type == "MESH" and found.override_library)
    for frame in FRAMES:
        bpy.context.scene.frame_set(frame)
        bpy.context.view_layer.update()
        points[f"Override_{frame}"] = points_of_object(override)
    np.savez_compressed(folder / f"shown_0.1_blender_{VERSION}.npz", **points)


def points_of_object(found):
    mesh = found.evaluated_get(bpy.context.evaluated_depsgraph_get()).data
    points = np.empty(len(mesh.vertices) * 3, np.float32)
    mesh.vertices.foreach_get("co", points)
    return points.reshape(-1, 3)


if __name__ == "__main__":
    main(Path(sys.argv[1]))
