# SPDX-License-Identifier: GPL-3.0-or-later
"""Fixtures with scenes. Each test starts in an empty file, with the installed extension enabled.

`scripts/test.py` runs all tests. To run some of them:
python3 scripts/run_in_blender.py scripts/testing/pytest_in_blender.py tests/blender -k NAME
"""

import math
import sys
from pathlib import Path

import bpy
import addon_utils
import numpy as np
import pytest
from bl_ext.user_default.sinew.live import session
from bl_ext.user_default.sinew.scene import characters

sys.path.append(str(Path(__file__).resolve().parents[2] / "scripts"))


# sides of the arm below: when `bend` closes the elbow, a muscle at FLEXOR shortens and one at EXTENSOR lengthens
FLEXOR, EXTENSOR = -math.pi / 2, math.pi / 2


@pytest.fixture(autouse=True)
def empty_file():
    """Starts each test with the empty factory file, and with factory preferences if a test changed them (80 ms)."""
    preferences = bpy.context.preferences
    if preferences.is_dirty or not hasattr(bpy.types.Object, "sinew"):
        bpy.ops.wm.read_factory_settings(use_empty=True)
        preferences.is_dirty = False  # enabling Sinew marks the preferences as changed
    else:
        bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    assert hasattr(bpy.types.Object, "sinew")


@pytest.fixture(scope="session")
def body_file(tmp_path_factory):
    """The MakeHuman body, saved once."""
    from data import body_in_blender

    bpy.ops.wm.read_factory_settings(use_empty=True)
    body_in_blender.build()
    path = tmp_path_factory.mktemp("body") / "body.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(path), compress=False)
    return str(path)


@pytest.fixture
def real_body(body_file):
    """(mesh, rig): the MakeHuman body of 13,380 vertices and 163 bones."""
    bpy.ops.wm.open_mainfile(filepath=body_file)
    return bpy.data.objects["Body"], bpy.data.objects["Rig"]


@pytest.fixture
def rigify():
    """Enables Rigify during a test."""
    addon_utils.enable("rigify", default_set=True)
    yield
    addon_utils.disable("rigify", default_set=True)


@pytest.fixture
def arm():
    """(mesh, rig): a round arm of two bones, 0.6 m along X, with 480 vertices and smooth weights at the elbow."""
    return make_arm()


def make_arm(name="Arm", rings=24, around=20, radius=0.05):
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
    return skin, rig


def select(*objects):
    """Selects only these objects. The first is active."""
    for found in bpy.context.view_layer.objects:
        found.select_set(False)
    for found in objects:
        found.select_set(True)
    bpy.context.view_layer.objects.active = objects[0]


def add_muscle(rig, **settings):
    """Adds a muscle from "upper" to "lower" with the operator; returns its Empty."""
    select(rig)
    before = set(bpy.data.objects)
    bpy.ops.sinew.add_tissue(**{"kind": "MUSCLE", "origin_bone": "upper", "insertion_bone": "lower"} | settings)
    return (set(bpy.data.objects) - before).pop()


def bind(skin):
    select(skin)
    bpy.ops.sinew.bind()


def bend(rig, angle, bone="lower", axis=2):
    """Rotates a bone about a local axis, in radians, and lets Blender evaluate."""
    pose_bone = rig.pose.bones[bone]
    pose_bone.rotation_mode = "XYZ"
    pose_bone.rotation_euler[axis] = angle
    bpy.context.view_layer.update()


def key_bend(rig, angles, bone="lower"):
    """Keys the rotation of a bone about its Z. angles: by frame, in radians."""
    for frame, angle in angles.items():
        bend(rig, angle, bone)
        rig.pose.bones[bone].keyframe_insert("rotation_euler", frame=frame)


def evaluated_points(skin):
    """(vertices, 3) float64: the points after all modifiers, object space."""
    return points_of_evaluated(skin.evaluated_get(bpy.context.evaluated_depsgraph_get()))


def points_of_evaluated(evaluated):
    """(vertices, 3) float64: the points of an evaluated mesh object, object space."""
    points = np.empty(len(evaluated.data.vertices) * 3, np.float32)
    evaluated.data.vertices.foreach_get("co", points)
    return points.reshape(-1, 3).astype(np.float64)


def rest_points(skin):
    points = np.empty(len(skin.data.vertices) * 3, np.float32)
    skin.data.vertices.foreach_get("co", points)
    return points.reshape(-1, 3).astype(np.float64)


def armature_alone(skin):
    """(vertices, 3): the points that Blender's modifiers give without Sinew's."""
    modifier = next(modifier for modifier in skin.modifiers if modifier.type == "NODES")
    modifier.show_viewport = False
    points = evaluated_points(skin)
    modifier.show_viewport = True
    bpy.context.view_layer.update()
    return points


def save_and_take(path, link=False):
    """Saves the file, starts an empty one and appends or links all objects from it."""
    bpy.ops.wm.save_as_mainfile(filepath=str(path))
    bpy.ops.wm.read_factory_settings(use_empty=True)
    with bpy.data.libraries.load(str(path), link=link) as (source, target):
        target.objects = list(source.objects)
    for found in target.objects:
        bpy.context.scene.collection.objects.link(found)
    bpy.context.view_layer.update()


def save_character(path):
    """Saves all objects in the collection "Character" as a library, and starts an empty file."""
    collection = bpy.data.collections.new("Character")
    bpy.context.scene.collection.children.link(collection)
    for found in bpy.data.objects:
        for other in found.users_collection:
            other.objects.unlink(found)
        collection.objects.link(found)
    bpy.ops.wm.save_as_mainfile(filepath=path)
    bpy.ops.wm.read_factory_settings(use_empty=True)


def link_character(path):
    """(mesh, rig): the character of a library, linked and overridden."""
    with bpy.data.libraries.load(path, link=True) as (_source, target):
        target.collections = ["Character"]
    made = target.collections[0].override_hierarchy_create(bpy.context.scene, bpy.context.view_layer)
    of_type = {found.type: found for found in made.all_objects}
    return of_type["MESH"], of_type["ARMATURE"]


@pytest.fixture
def muscled(arm):
    """(mesh, rig): a bound arm at rest."""
    skin, rig = arm
    add_muscle(rig, around=FLEXOR)
    bind(skin)
    return skin, rig


@pytest.fixture
def waving(arm):
    """(mesh, rig): a bound arm that bends by 80 degrees over frames 1 to 12."""
    skin, rig = arm
    add_muscle(rig, around=FLEXOR)
    key_bend(rig, {1: 0.0, 12: 1.4})
    bind(skin)
    bpy.context.scene.frame_set(1)
    return skin, rig


@pytest.fixture
def bent(arm):
    """(mesh, rig): a bound, bent arm without elastic skin, so that the effect of a muscle is exact."""
    skin, rig = arm
    add_muscle(rig, around=FLEXOR)
    skin.sinew.skin.elastic = False
    bind(skin)
    bend(rig, 1.2)
    return skin, rig


def lifts(skin):
    """(vertices,): the distance by which Sinew moves each vertex."""
    return np.linalg.norm(evaluated_points(skin) - armature_alone(skin), axis=1)


def lifted(skin):
    return np.flatnonzero(lifts(skin) > 1e-6)


def set_bone(rig, bone, **settings):
    for name, value in settings.items():
        setattr(rig.pose.bones[bone].sinew, name, value)
    bpy.context.view_layer.update()


def add_attribute(skin, values, name="sinew_muscle_influence", kind="FLOAT", domain="POINT"):
    attribute = skin.data.attributes.new(name, kind, domain)
    attribute.data.foreach_set("value", values)
    skin.data.update()
    bpy.context.view_layer.update()
    return attribute


def points_of_the_core(skin, rig):
    """(vertices, 3) float32: the skin that the core computes from the bind and the pose of the last frame."""
    state, rig_state = session.cached_skin(skin), session.cached_rig(rig)
    points = np.empty((len(skin.data.vertices), 3), np.float32)
    state.skin.deform(rig_state.pose, rig_state.tension, points)
    return points


def evaluated_after_binding_again(skin, rig):
    """The points after a new bind from the file alone."""
    session.forget()
    rig.update_tag()
    bpy.context.view_layer.update()
    return evaluated_points(skin)


def points_over(skin, frames):
    """(frames, vertices, 3) float64: the points after all modifiers in each frame."""
    points = []
    for frame in frames:
        bpy.context.scene.frame_set(frame)
        points.append(evaluated_points(skin))
    return np.array(points)


def snapshot(skin, rig):
    """Everything of a character and its file that a user would notice."""
    return {
        "objects": sorted(found.name for found in bpy.data.objects),
        "collections": sorted(found.name for found in bpy.data.collections),
        "node groups": sorted(found.name for found in bpy.data.node_groups),
        "actions": sorted(found.name for found in bpy.data.actions),
        "modifiers": [modifier.name for modifier in skin.modifiers],
        "attributes": sorted(attribute.name for attribute in skin.data.attributes),
        "keys": [key.name for key in skin.data.shape_keys.key_blocks] if skin.data.shape_keys else None,
        "groups": [group.name for group in skin.vertex_groups],
        "points": rest_points(skin).tobytes(),
        "custom": [sorted(carrier.keys()) for carrier in (skin, rig, skin.data, rig.data)],
        "settings": skin.is_property_set("sinew"),
        "constraints": [len(bone.constraints) for bone in rig.pose.bones],
    }


@pytest.fixture(params=[False, True], ids=["bare", "elastic"])
def bent_skin(arm, request):
    """(mesh, rig): a bound, bent arm, without and with the elastic skin."""
    skin, rig = arm
    add_muscle(rig, around=FLEXOR)
    skin.sinew.skin.elastic = request.param
    bind(skin)
    bend(rig, 1.2)
    return skin, rig


@pytest.fixture
def human(rigify):
    """Rigify's human metarig with the human preset: muscles with via points and wraps."""
    bpy.ops.object.armature_human_metarig_add()
    rig = bpy.context.object
    bpy.ops.sinew.add_preset(name="human")
    bpy.context.view_layer.update()
    return rig


def delete_in_viewport(name):
    """Deletes an object with the operator of the viewport."""
    select(bpy.data.objects[name])
    bpy.ops.object.delete()
    bpy.context.view_layer.update()


def tissue_names(rig):
    return [empty.name for empty in characters.tissues_of(rig)]


def problems_of(rig):
    bpy.context.view_layer.update()
    return session.cached_rig(rig).problems
