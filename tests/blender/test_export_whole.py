# SPDX-License-Identifier: GPL-3.0-or-later
"""Exported files hold what Blender shows: drivers under any parent, masked keys, modifiers, and the whole character."""

import bpy
import bmesh
import numpy as np
import pytest
from conftest import FLEXOR, add_muscle, bind, key_bend, make_arm, rest_points, select
from exports import exported
from test_muscle_bones import bake_bones, waving  # noqa: F401 - waving is a fixture

FRAMES = range(1, 13)
RIGGED = ("GLTF", "FBX", "USD")
# USD stores bone scales as 16-bit floats, and Blender leaves out scales close to those of the frame before
MOST_MM = {".glb": 0.02, ".fbx": 0.02, ".usdc": 2.0}


def bake_correctives(skin, **settings):
    scene = bpy.context.scene
    scene.frame_start, scene.frame_end = 1, 12
    select(skin)
    bpy.ops.sinew.bake_correctives(**{"joints": "lower", "tolerance": 2.0} | settings)


def files_of(rig, points, folder, name):
    """Exports a rig to each format. Returns what `exported.round_trips` takes."""
    select(rig)
    files = []
    for file_format in RIGGED:
        path = folder / f"{name}{exported.SUFFIXES[file_format]}"
        assert bpy.ops.sinew.export(filepath=str(path), format=file_format) == {"FINISHED"}
        files.append((path, points, None))
    return files


def files_of_both(skin, rig, folder):
    """Exports a character with its correctives, and then its export copy. Returns also the meshes' shown points."""
    files = files_of(rig, exported.shown(skin, FRAMES), folder, "character")
    mesh, _rig_copy = bake_bones(rig)
    return files + files_of(rig, exported.shown(mesh, FRAMES), folder, "copy")


def contents_of(files):
    """Checks that files show their points in a Blender without Sinew. Returns what each holds."""
    backs = exported.round_trips(files, 1)
    for (path, _points, _mesh), back in zip(files, backs, strict=True):
        assert back.max_mm < MOST_MM[path.suffix] and back.missing == 0, (path.name, back.max_mm)
    return [back.contents for back in backs]


def all_names():
    return sorted(found.name for kind in (bpy.data.objects, bpy.data.meshes, bpy.data.shape_keys) for found in kind)


@pytest.mark.parametrize("parent", ["none", "other"])
def test_drivers_reach_every_format_under_any_parent(waving, parent, tmp_path):  # noqa: F811
    skin, rig = waving
    skin.parent = None
    if parent == "other":
        skin.parent = bpy.data.objects.new("Group", None)
        bpy.context.scene.collection.objects.link(skin.parent)
        skin.parent.location = (0.1, 0.2, 0.0)
        skin.matrix_parent_inverse.translation = (-0.1, -0.2, 0.0)
    bpy.context.view_layer.update()
    bake_correctives(skin)
    files = files_of(rig, exported.shown(skin, FRAMES), tmp_path, "character")
    mesh, _rig_copy = bake_bones(rig)
    names = all_names()
    files += files_of(rig, exported.shown(mesh, FRAMES), tmp_path, "copy")
    assert all_names() == names
    for contents in contents_of(files):
        assert contents["key curves"] == len(mesh.data.shape_keys.key_blocks) - 1 > 0


def add_group(skin, name, weights):
    group = skin.vertex_groups.new(name=name)
    for vertex, weight in enumerate(weights):
        group.add((vertex,), float(weight), "REPLACE")


def test_masks_relative_keys_and_muted_keys_are_as_in_blender(waving, tmp_path):  # noqa: F811
    """A muted key with a driver must not take the other drivers' animation from the file."""
    skin, rig = waving
    bake_correctives(skin)
    rest = rest_points(skin)
    add_group(skin, "half", np.clip(4.0 * rest[:, 0], 0.0, 1.0))
    for name, value in (("masked", 1.0), ("relative", 0.5), ("muted", 1.0)):
        key = skin.shape_key_add(name=name, from_mix=False)
        key.points.foreach_set("co", (rest + (0.0, 0.1, 0.05)).astype(np.float32).reshape(-1))
        key.value = value
    keys = skin.data.shape_keys.key_blocks
    keys["masked"].vertex_group = keys["relative"].vertex_group = "half"
    keys["relative"].points.foreach_set("co", (rest + (0.0, 0.1, -0.02)).astype(np.float32).reshape(-1))
    keys["relative"].relative_key = keys["masked"]
    keys["muted"].mute = True
    keys["muted"].driver_add("value").driver.expression = "1.0"
    for contents in contents_of(files_of_both(skin, rig, tmp_path)):
        assert contents["keys"] == len(keys) - 2
        assert contents["key curves"] > 0
    assert keys["masked"].vertex_group == "half" and keys["muted"].mute


def test_a_mirror_modifier_before_the_armature_is_refused_at_the_bind():
    """Half an arm across the plane y = 0: the copies would get the correction of their originals."""
    with pytest.raises(RuntimeError, match="'Mirror' acts before the Armature modifier"):
        half_arm()


def half_arm():
    """(mesh, rig): a bound arm of which the half with y > 0 is mirrored, without a seam, bending over frames 1 to 12."""
    skin, rig = make_arm()
    points, mesh = rest_points(skin), skin.data
    edited = bmesh.new()
    edited.from_mesh(mesh)
    edited.verts.ensure_lookup_table()
    bmesh.ops.delete(edited, geom=[edited.verts[i] for i in np.flatnonzero(points[:, 1] < 1e-4)], context="VERTS")
    edited.to_mesh(mesh)
    edited.free()
    mirror = skin.modifiers.new("Mirror", "MIRROR")
    mirror.use_axis = (False, True, False)
    mirror.use_mirror_merge = False
    skin.modifiers.move(1, 0)
    add_muscle(rig, around=FLEXOR)
    key_bend(rig, {1: 0.0, 12: 1.2})
    bind(skin)
    bpy.context.scene.frame_set(1)
    return skin, rig


def test_a_modifier_after_the_armature_is_named(waving, tmp_path, capfd):  # noqa: F811
    skin, rig = waving
    bake_correctives(skin)
    skin.modifiers.new("Smoother", "SUBSURF")
    select(rig)
    assert bpy.ops.sinew.export(filepath=str(tmp_path / "arm.glb")) == {"FINISHED"}
    assert "Arm: Smoother after the Armature modifier is not in the file" in capfd.readouterr().out


@pytest.mark.parametrize("file_format", RIGGED)
def test_eyes_and_clothes_are_in_the_file(waving, file_format, tmp_path):  # noqa: F811
    """Body and clothes are bound; one eye follows by a modifier, the other is a child of a bone."""
    skin, rig = waving
    clothes = skin.copy()
    clothes.data, clothes.name = skin.data.copy(), "Clothes"
    bpy.context.scene.collection.objects.link(clothes)
    bind(clothes)
    bpy.ops.mesh.primitive_uv_sphere_add(segments=8, ring_count=6, radius=0.02, location=(0.6, 0.0, 0.1))
    skinned = bpy.context.object
    skinned.name = skinned.data.name = "SkinnedEye"
    add_group(skinned, "lower", np.ones(len(skinned.data.vertices)))
    skinned.parent = rig
    skinned.modifiers.new("Armature", "ARMATURE").object = rig
    bpy.ops.mesh.primitive_uv_sphere_add(segments=8, ring_count=6, radius=0.02)
    child = bpy.context.object
    child.name = child.data.name = "ChildEye"
    child.parent, child.parent_type, child.parent_bone = rig, "BONE", "lower"
    bpy.context.view_layer.update()
    bake_bones(rig)
    bpy.context.scene.frame_start, bpy.context.scene.frame_end = 1, 12
    select(rig)
    assert bpy.ops.sinew.export(filepath=str(tmp_path / "file"), format=file_format) == {"FINISHED"}
    path = tmp_path / f"file{exported.SUFFIXES[file_format]}"
    files = [(path, exported.shown(mesh, FRAMES), mesh.name) for mesh in (skinned, child)]
    for back in exported.round_trips(files, 1):
        assert back.max_mm < MOST_MM[path.suffix] and back.missing == 0


def empty_parent(rig, scale, rotation):
    rig.parent = bpy.data.objects.new("Group", None)
    bpy.context.scene.collection.objects.link(rig.parent)
    rig.parent.scale, rig.parent.rotation_euler = scale, rotation


def apart_m(skin, rig):
    """Bakes bones. Returns the largest distance of the copy from the live skin, and the copy's points over the frames."""
    mesh, _rig_copy = bake_bones(rig)
    live, shown = exported.shown(skin, FRAMES), exported.shown(mesh, FRAMES)
    return float(np.linalg.norm(shown - live, axis=2).max()), shown


@pytest.mark.parametrize("scale", ["uneven", "sheared", "negative", "moving parent"])
def test_an_export_copy_has_an_uneven_or_negative_scale_applied(waving, scale, tmp_path):  # noqa: F811
    """The copy is as close to the live skin as without the scale, in the copy's lengths, and the files show the copy."""
    skin, rig = waving
    bake_correctives(skin)
    skin.sinew.skin.live = True
    even_m, _shown = apart_m(skin, rig)
    if scale == "uneven":
        rig.scale = (1.0, 1.4, 0.7)
    elif scale == "negative":
        rig.scale = (-1.0, 1.0, 1.0)
    elif scale == "sheared":
        empty_parent(rig, (1.0, 2.0, 0.5), (0.3, 0.4, 0.2))
        rig.rotation_euler = (0.5, -0.3, 0.8)
    else:
        empty_parent(rig, (0.5, 0.5, 0.5), (0.3, 0.4, 0.2))
        for frame, x in ((1, 0.0), (12, 0.5)):
            rig.parent.location.x = x
            rig.parent.keyframe_insert("location", frame=frame)
    bpy.context.view_layer.update()
    longest = np.linalg.norm(np.array(rig.matrix_world)[:3, :3], 2)
    scaled_m, shown = apart_m(skin, rig)
    assert scaled_m < 1.02 * longest * even_m
    files = files_of(rig, shown, tmp_path, "copy")
    contents_of(files)


def test_the_motion_of_a_parent_is_refused_without_an_export_copy(waving, tmp_path):  # noqa: F811
    skin, rig = waving
    bake_correctives(skin)
    empty_parent(rig, (1.0, 1.0, 1.0), (0.0, 0.0, 0.3))
    select(rig)
    assert bpy.ops.sinew.export(filepath=str(tmp_path / "arm.glb")) == {"FINISHED"}
    for frame, x in ((1, 0.0), (12, 0.5)):
        rig.parent.location.x = x
        rig.parent.keyframe_insert("location", frame=frame)
    bpy.context.scene.frame_set(7)
    with pytest.raises(RuntimeError, match="Arm Rig moves with its parent Group"):
        bpy.ops.sinew.export(filepath=str(tmp_path / "arm.glb"))
    assert bpy.context.scene.frame_current == 7


def test_an_uneven_scale_is_refused_without_an_export_copy(waving, tmp_path):  # noqa: F811
    skin, rig = waving
    bake_correctives(skin)
    rig.scale = (1.0, 1.0, -1.0)
    select(rig)
    with pytest.raises(RuntimeError, match="uneven or negative scale"):
        bpy.ops.sinew.export(filepath=str(tmp_path / "arm.glb"))
