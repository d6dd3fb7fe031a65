# SPDX-License-Identifier: GPL-3.0-or-later
"""Steps of the random walk that edit the file: poses, tissues, meshes, bones, animation. Each takes the world."""

import bpy
import bmesh
import numpy as np
from world import Nothing, World

SKIN_SETTINGS = {
    "anchoring": ("BLENDED", "NEAREST"),
    "motion_source": ("SWELLING", "FULL"),
    "scale_fat": (False, True),
    "falloff": (0.0, 0.05, 0.2),
    "muscle_influence": (0.0, 1.0, 2.0),
    "elastic": (True, False),
    "iterations": (0, 3, 10),
    "energy": ("AS_RIGID_AS_POSSIBLE", "SPRINGS"),
    "anchor_stiffness": (0.1, 1.0, 4.0),
    "slack": (0.0, 0.02),
    "fat_sliding": (0.0, 1.0),
    "contacts": (True, False),
    "safeguard": (False, True),
    "live": (True, True, False),
}
TISSUE_SETTINGS = {
    "origin_tendon": (0.0, 0.03),
    "insertion_tendon": (0.0, 0.03),
    "volume_keeping": (0.0, 1.0),
    "tension": (0.0, 0.5, 1.0),
    "origin_bone": ("upper", "lower"),
    "insertion_bone": ("upper", "lower", ""),
    "kind": ("MUSCLE", "MUSCLE", "BONE", "STUFFING", "SPHERE", "NONE"),
}
BONE_SETTINGS = ("muscle_influence", "slack", "crease", "keep_volume", "anchor_stiffness")


def turn_bone(world: World):
    bone = world.bone(world.rig())
    bone.rotation_mode = world.pick(("XYZ", "QUATERNION", "AXIS_ANGLE"))
    if bone.rotation_mode == "XYZ":
        bone.rotation_euler = [world.number(-1.5, 1.5) for _ in range(3)]
    elif bone.rotation_mode == "QUATERNION":
        bone.rotation_quaternion = [world.number(0.2, 1.0), *(world.number(-0.8, 0.8) for _ in range(3))]
    else:
        bone.rotation_axis_angle = [world.number(-2.0, 2.0), *(world.number(0.1, 1.0) for _ in range(3))]


def scale_bone(world: World):
    world.bone(world.rig()).scale = [world.pick((1.0, 1.0, 0.5, 1.5, 0.0)) for _ in range(3)]


def key_bone(world: World):
    bone = world.bone(world.rig())
    bone.keyframe_insert(world.pick(("rotation_euler", "location", "scale")), frame=world.pick((1, 5, 10)))


def change_frame(world: World):
    bpy.context.scene.frame_set(world.pick(range(1, 12)), subframe=world.pick((0.0, 0.0, 0.5)))


def change_tissue(world: World):
    tissue = world.tissue()
    name = world.pick(TISSUE_SETTINGS)
    setattr(tissue.sinew.tissue, name, world.pick(TISSUE_SETTINGS[name]))


def move_tissue(world: World):
    tissue = world.tissue()
    what = world.pick(("location", "rotation_euler", "scale", "rotation_mode", "empty_display_size", "hide_viewport"))
    if what == "rotation_mode":
        tissue.rotation_mode = world.pick(("XYZ", "ZYX", "QUATERNION", "AXIS_ANGLE"))
    elif what == "empty_display_size":
        tissue.empty_display_size = world.pick((0.8, 1.0, 1.2))
    elif what == "hide_viewport":
        tissue.hide_viewport = not tissue.hide_viewport
    elif what == "scale":
        tissue.scale = [part * world.number(0.8, 1.25) for part in tissue.scale]
    else:
        value = getattr(tissue, what)
        setattr(tissue, what, [part + world.number(-0.02, 0.02) for part in value])
    # Blender does not report edits of an Empty that is disabled or in an excluded collection: the next evaluation sees them
    if tissue.parent:
        tissue.parent.update_tag()


def animate_tissue(world: World):
    tissue = world.tissue()
    if world.chance(0.2):
        tissue.animation_data_clear()
    elif world.chance(0.3):
        tissue.driver_add("scale", 0).driver.expression = "0.03 + 0.001 * frame"
    else:
        for frame in (1, 10):
            tissue.sinew.tissue.tension, tissue.location.x = world.number(0.0, 1.0), tissue.location.x + 0.01
            tissue.keyframe_insert(world.pick(("sinew.tissue.tension", "location")), frame=frame)


def animate_skin(world: World):
    skin = world.skin()
    if world.chance(0.3):
        skin.animation_data_clear()
        return
    for frame in (1, 10):
        skin.sinew.skin.muscle_influence = world.number(0.0, 2.0)
        skin.keyframe_insert("sinew.skin.muscle_influence", frame=frame)


def animate_bone_setting(world: World):
    rig = world.rig()
    bone = world.bone(rig)
    for frame in (1, 10):
        bone.sinew.muscle_influence = world.number(0.0, 2.0)
        name = bpy.utils.escape_identifier(bone.name)
        rig.keyframe_insert(f'pose.bones["{name}"].sinew.muscle_influence', frame=frame)


def change_skin(world: World):
    skin = world.skin()
    name = world.pick(SKIN_SETTINGS)
    setattr(skin.sinew.skin, name, world.pick(SKIN_SETTINGS[name]))


def change_bone_setting(world: World):
    setattr(world.bone(world.rig()).sinew, world.pick(BONE_SETTINGS), world.pick((0.0, 0.5, 1.0)))


def move_vertices(world: World):
    mesh = world.mesh().data
    for _ in range(5):
        vertex = world.pick(mesh.vertices)
        vertex.co = [part + world.number(-0.01, 0.01) for part in vertex.co]
    mesh.update()


def sculpt(world: World):
    """A stroke: vertices move in Sculpt Mode."""
    skin = world.skin(editable=True)
    world.activate(skin)
    bpy.ops.object.mode_set(mode="SCULPT")
    move_vertices(world)
    skin.data.update_tag()


def paint_weights(world: World):
    """A stroke: weights of a group change in Weight Paint Mode."""
    skin = world.skin(editable=True)
    world.activate(skin)
    bpy.ops.object.mode_set(mode="WEIGHT_PAINT")
    group = world.pick(skin.vertex_groups)
    for _ in range(8):
        group.add([world.pick(range(len(skin.data.vertices)))], world.number(0.0, 1.0), "REPLACE")
    skin.data.update()


def paint_region(world: World):
    skin = world.skin(editable=True)
    name = world.pick(("sinew_muscle_influence", "sinew_relaxation", "sinew_slack"))
    attribute = skin.data.attributes.get(name)
    if attribute and world.chance(0.3):
        skin.data.attributes.remove(attribute)
        return
    if attribute is None:
        attribute = skin.data.attributes.new(name, "FLOAT", "POINT")
    if attribute is None:
        raise Nothing
    attribute.data.foreach_set("value", np.full(len(attribute.data), world.pick((0.0, 0.5, 1.0)), np.float32))
    skin.data.update()


def edit_mesh(world: World):
    """Deletes faces, dissolves vertices, rotates edges or subdivides, by a script or in Edit Mode."""
    skin = world.mesh()
    in_edit_mode = world.chance()
    if in_edit_mode:
        world.activate(skin)
        bpy.ops.object.mode_set(mode="EDIT")
        editing = bmesh.from_edit_mesh(skin.data)
    else:
        editing = bmesh.new()
        editing.from_mesh(skin.data)
    editing.faces.ensure_lookup_table(), editing.edges.ensure_lookup_table(), editing.verts.ensure_lookup_table()
    what = world.pick(("faces", "edges", "vertices", "move"))
    if what == "faces" and len(editing.faces) > 40:
        bmesh.ops.delete(editing, geom=[world.pick(editing.faces)], context="FACES_ONLY")
    elif what == "edges" and editing.edges:
        bmesh.ops.rotate_edges(editing, edges=[world.pick(editing.edges)])
    elif what == "vertices" and 40 < len(editing.verts) < 400:
        if world.chance():
            bmesh.ops.delete(editing, geom=[world.pick(editing.verts)], context="VERTS")
        else:
            bmesh.ops.subdivide_edges(editing, edges=[world.pick(editing.edges)], cuts=1)
    elif editing.verts:
        world.pick(editing.verts).co.z += 0.01
    if in_edit_mode:
        bmesh.update_edit_mesh(skin.data)
        if world.chance(0.8):
            bpy.ops.object.mode_set(mode="OBJECT")
    else:
        editing.to_mesh(skin.data)
        editing.free()
        skin.data.update()


def change_groups(world: World):
    skin = world.skin(editable=True)
    what = world.pick(("rename", "rename", "remove", "new"))
    if what == "new":
        skin.vertex_groups.new(name=world.pick(("upper", "lower", "Group")))
    elif what == "remove" and len(skin.vertex_groups) > 2:
        skin.vertex_groups.remove(world.pick(skin.vertex_groups))
    else:
        world.pick(skin.vertex_groups).name = world.pick(("upper", "lower", "nothing"))


def change_shape_keys(world: World):
    skin = world.skin(editable=True)
    keys = skin.data.shape_keys
    if keys is None or (len(keys.key_blocks) < 4 and world.chance()):
        skin.shape_key_add(name="Key", from_mix=False)
    elif world.chance(0.3):
        key = world.pick(keys.key_blocks)
        for _ in range(5):
            world.pick(key.data).co.z += world.number(-0.01, 0.01)
        skin.data.update_tag()
    elif world.chance(0.1):
        skin.shape_key_clear()
    else:
        key = world.pick(keys.key_blocks)
        key.value, key.mute = world.number(0.0, 1.0), world.chance(0.2)


def move_object(world: World):
    moved = world.pick(world.objects("MESH") + world.objects("ARMATURE"))
    if world.chance():
        moved.location.x += world.number(-0.1, 0.1)
    elif world.chance():
        moved.rotation_euler.x += world.number(-0.5, 0.5)
    else:
        moved.scale = [world.pick((1.0, 1.0, 1.2, -1.0))] * 3


def change_armature(world: World):
    """Bones move, appear, vanish, or get other names or settings, in Edit Mode or by a script."""
    rig = world.rig()
    what = world.pick(("move", "deform", "segments", "rename", "new", "rest"))
    if what == "deform":
        bone = world.pick(rig.data.bones)
        bone.use_deform = not bone.use_deform
    elif what == "segments":
        world.pick(rig.data.bones).bbone_segments = world.pick((1, 1, 3))
    elif what == "rest":
        rig.data.pose_position = world.pick(("POSE", "POSE", "REST"))
    elif what == "rename":
        world.pick(rig.data.bones).name = world.pick(("upper", "lower", "third"))
    else:
        world.activate(rig)
        bpy.ops.object.mode_set(mode="EDIT")
        bones = rig.data.edit_bones
        if what == "new" and len(bones) < 4:
            bone = bones.new("third")
            bone.head, bone.tail, bone.parent = (0.6, 0.0, 0.0), (0.7, 0.0, 0.0), bones[-1]
        else:
            world.pick(bones).tail.z += world.number(-0.02, 0.02)
        if world.chance(0.85):
            bpy.ops.object.mode_set(mode="OBJECT")


STEPS = (
    (turn_bone, 8), (scale_bone, 1), (key_bone, 2), (change_frame, 6), (change_tissue, 4), (move_tissue, 5),
    (animate_tissue, 2), (animate_skin, 1), (animate_bone_setting, 1), (change_skin, 4), (change_bone_setting, 2),
    (move_vertices, 2), (sculpt, 2), (paint_weights, 2), (paint_region, 2), (edit_mesh, 3), (change_groups, 1),
    (change_shape_keys, 2), (move_object, 2), (change_armature, 3),
)  # fmt: skip
