# SPDX-License-Identifier: GPL-3.0-or-later
"""Growing a skin over tissues, with weights, UVs and a live bind, and growing it again with its painted values."""

from collections import Counter

import bpy
import numpy as np
import pytest
from conftest import add_muscle, armature_alone, bend, evaluated_points, rest_points, select

LEAST_QUALITY = 0.1


@pytest.fixture
def cat(rigify):
    """Rigify's cat with its preset."""
    bpy.ops.object.armature_cat_metarig_add()
    bpy.ops.sinew.add_preset(name="cat")
    return bpy.context.object


@pytest.fixture
def limb(arm):
    """A rig of two bones along X with a muscle and two stuffings, without a mesh."""
    skin, rig = arm
    bpy.data.meshes.remove(skin.data)
    add_muscle(rig)
    for bone in ("upper", "lower"):
        bpy.ops.sinew.add_tissue(kind="STUFFING", origin_bone=bone)
    return rig


def grow(rig, **options):
    select(rig)
    assert bpy.ops.sinew.grow_skin(**options) == {"FINISHED"}
    return next(found for found in bpy.data.objects if found.type == "MESH" and found.sinew.skin.growth.is_grown)


def require_closed(mesh):
    sides = {}
    for face in mesh.polygons:
        corners = list(face.vertices)
        assert len(corners) == 4
        for side in zip(corners, corners[1:] + corners[:1]):
            assert side not in sides
            sides[side] = face
    assert all((b, a) in sides for a, b in sides)
    return len(mesh.vertices) - len(sides) // 2 + len(mesh.polygons)


def volume_of(mesh):
    return sum(face.center.dot(face.normal) * face.area for face in mesh.polygons) / 3.0


def test_the_cats_skin_has_as_many_vertices_as_the_papers(cat):
    skin = grow(cat, resolution=103)
    assert 5000 < len(skin.data.vertices) < 6200  # Wilhelms 1997: 5,518
    require_closed(skin.data)
    assert volume_of(skin.data) > 0.0
    assert not skin.data.validate()
    points = rest_points(skin)
    lattice = {tuple(row) for row in np.round(points * [-1.0, 1.0, 1.0] / 2e-5).astype(int)}
    steps = np.stack(np.meshgrid(*[[-1, 0, 1]] * 3), axis=-1).reshape(-1, 3)
    for row in np.round(points / 2e-5).astype(int):
        assert any(tuple(row + step) in lattice for step in steps)


def test_a_grown_skin_has_weights_uvs_and_a_live_bind(cat):
    skin = grow(cat)
    assert skin.sinew.skin.bound and skin.sinew.skin.live and skin.parent == cat
    assert skin.data.uv_layers.active is not None
    assert bpy.context.object == cat and bpy.context.selected_objects == [cat]
    for vertex in skin.data.vertices:
        assert 1 <= len(vertex.groups) <= 4
        assert sum(element.weight for element in vertex.groups) == pytest.approx(1.0, abs=1e-5)
    assert all(group.name in cat.data.bones for group in skin.vertex_groups)
    at_rest = evaluated_points(skin)
    np.testing.assert_allclose(at_rest, rest_points(skin), atol=1e-6)
    bend(cat, 0.8, "shin.L", 0)
    moved = np.linalg.norm(evaluated_points(skin) - at_rest, axis=1)
    assert moved.max() > 0.03 and np.median(moved) < 1e-4  # the leg, but not the rest of the cat
    alone = np.linalg.norm(armature_alone(skin) - at_rest, axis=1)
    assert alone.max() > 0.03  # a plain Armature modifier also moves it


def test_features_are_added_to_the_first_skin_only(cat):
    grow(cat)
    added = Counter(
        found.name.split(".")[0].split(" ")[0]
        for found in bpy.data.objects
        if found.type == "EMPTY" and "stuffing" not in found.name and found.sinew.tissue.kind == "STUFFING"
    )
    assert added == {"Eye": 2, "Ear": 4, "Muzzle": 3, "Nose": 1, "Chin": 1, "Cheek": 2, "Toe": 16, "Claw": 16, "Pad": 20}
    select(bpy.data.objects["Ear.L"])
    bpy.ops.object.delete()
    grow(cat)
    assert bpy.data.objects.get("Ear.L") is None or not bpy.data.objects["Ear.L"].users_collection


def test_eyes_and_claws_have_materials_with_an_outline_along_edges(cat):
    skin = grow(cat, resolution=160)
    mesh = skin.data
    assert [material.name for material in mesh.materials] == ["Skin", "Eyes", "Nose and Pads", "Claws"]
    eyes = [face for face in mesh.polygons if face.material_index == 1]
    assert {face.center.x > 0.0 for face in eyes} == {True, False}
    sides = Counter(tuple(sorted(side)) for face in eyes for side in face.edge_keys)
    border = {vertex for side, count in sides.items() if count == 1 for vertex in side}
    for name in ("Eye.L", "Eye.R"):
        eye = bpy.data.objects[name]
        centre = cat.matrix_world.inverted() @ eye.matrix_world.translation
        distances = [(mesh.vertices[vertex].co - centre).length for vertex in border]
        near = [distance for distance in distances if distance < 0.02]
        assert len(near) > 8 and max(near) - min(near) < 0.6 * 0.0052  # a ring around the eye
    require_closed(mesh)


def test_features_can_be_left_out(cat):
    grow(cat, features=False)
    assert "Ear.L" not in bpy.data.objects


def test_fewer_faces(limb):
    skin = grow(limb, resolution=60)
    many = len(skin.data.polygons)
    skin = grow(limb, faces=many // 3)
    assert many // 3 * 0.8 < len(skin.data.polygons) <= many // 3
    require_closed(skin.data)


def test_growing_again_keeps_object_settings_materials_and_paint(limb):
    skin = grow(limb, resolution=40)
    skin.name = "Mine"
    skin.sinew.skin.muscle_influence = 1.5
    mesh = skin.data
    for name in ("left", "right"):
        mesh.materials.append(bpy.data.materials.new(name))
    for face in mesh.polygons:
        face.material_index = int(face.center.x > 0.3)
    paint = mesh.attributes.new("along", "FLOAT", "POINT")
    paint.data.foreach_set("value", [vertex.co.x for vertex in mesh.vertices])
    colours = mesh.color_attributes.new("Coat", "FLOAT_COLOR", "CORNER")
    for corner in colours.data:
        corner.color = (0.2, 0.4, 0.6, 1.0)
    group = skin.vertex_groups.new(name="mine")
    group.add([vertex.index for vertex in mesh.vertices if vertex.co.x > 0.3], 0.5, "REPLACE")
    modifiers = skin.modifiers.keys()

    again = grow(limb, resolution=60)
    assert again == skin and skin.name == "Mine" and skin.modifiers.keys() == modifiers
    assert skin.sinew.skin.muscle_influence == 1.5 and skin.sinew.skin.growth.resolution == 60 and skin.sinew.skin.bound
    mesh = skin.data
    assert [material.name for material in mesh.materials] == ["left", "right"]
    wrong = [face for face in mesh.polygons if face.material_index != int(face.center.x > 0.3)]
    assert all(abs(face.center.x - 0.3) < 0.02 for face in wrong)
    values = np.empty(len(mesh.vertices), np.float32)
    mesh.attributes["along"].data.foreach_get("value", values)
    np.testing.assert_allclose(values, rest_points(skin)[:, 0], atol=0.02)
    assert np.allclose([corner.color for corner in mesh.color_attributes["Coat"].data], (0.2, 0.4, 0.6, 1.0), atol=1e-3)
    for vertex in mesh.vertices:
        weights = {skin.vertex_groups[element.group].name: element.weight for element in vertex.groups}
        if abs(vertex.co.x - 0.3) > 0.02:
            assert weights.get("mine", 0.0) == pytest.approx(0.5 if vertex.co.x > 0.3 else 0.0, abs=1e-4)
    assert len(bpy.data.meshes) == 1
    # options that are not given keep their last values
    assert grow(limb) == skin and skin.sinew.skin.growth.resolution == 60


def test_growing_again_keeps_uvs_where_they_were(limb):
    """A map with a seam: each island is a linear function of the position, so that any transferred UV can be checked."""
    skin = grow(limb, resolution=40)
    mesh = skin.data
    layer = mesh.uv_layers.active
    layer.name = "Mine"

    def mapped(point, is_left):
        return (point[0] * 0.5 + (0.0 if is_left else 0.5), 0.5 + point[2])

    for face in mesh.polygons:
        is_left = face.center.y < 0.0
        for corner in face.loop_indices:
            layer.uv[corner].vector = mapped(mesh.vertices[mesh.loops[corner].vertex_index].co, is_left)
    again = grow(limb, resolution=70)
    mesh = again.data
    assert [found.name for found in mesh.uv_layers] == ["Mine"]
    wrong = 0
    for face in mesh.polygons:
        found = [tuple(mesh.uv_layers[0].uv[corner].vector) for corner in face.loop_indices]
        points = [mesh.vertices[mesh.loops[corner].vertex_index].co for corner in face.loop_indices]
        best = min(
            max(max(abs(a - b) for a, b in zip(uv, mapped(point, is_left))) for uv, point in zip(found, points))
            for is_left in (True, False)
        )
        wrong += best > 0.02
    assert wrong == 0  # no face is smeared across the seam


def test_growing_again_follows_the_anatomy_and_drops_distant_paint(limb):
    skin = grow(limb, resolution=40)
    skin.data.attributes.new("mark", "FLOAT", "POINT").data.foreach_set("value", [1.0] * len(skin.data.vertices))
    volume = volume_of(skin.data)
    lump = next(found for found in bpy.data.objects if found.name.startswith("Stuffing lower"))
    lump.scale = [3.0 * width for width in lump.scale]
    grow(limb)
    assert volume_of(skin.data) > 2.0 * volume
    values = [entry.value for entry in skin.data.attributes["mark"].data]
    assert min(values) == 0.0 and max(values) == pytest.approx(1.0)


def test_thickness_overall_and_by_tissue(limb):
    volume = volume_of(grow(limb, resolution=60).data)
    assert volume_of(grow(limb, thickness=0.01).data) > 1.1 * volume
    for found in bpy.data.objects:
        if found.type == "EMPTY":
            found.sinew.tissue.skin_thickness = 0.02 if found.name.startswith("Stuffing lower") else 0.0
    points = rest_points(grow(limb, thickness=0.0))
    assert np.ptp(points[points[:, 0] > 0.4][:, 2]) > np.ptp(points[points[:, 0] < 0.2][:, 2]) + 0.03


def test_fat_by_bone(limb):
    points = rest_points(grow(limb, resolution=60, thickness=0.01))
    limb.pose.bones["lower"].sinew.fat_thickness = 3.0
    fatter = rest_points(grow(limb))
    assert np.ptp(fatter[fatter[:, 0] > 0.4][:, 2]) > np.ptp(points[points[:, 0] > 0.4][:, 2]) + 0.03
    assert np.ptp(fatter[fatter[:, 0] < 0.1][:, 2]) == pytest.approx(np.ptp(points[points[:, 0] < 0.1][:, 2]), abs=0.004)


def test_a_posed_rig_grows_its_rest_shape(limb):
    at_rest = rest_points(grow(limb))
    bend(limb, 1.0)
    skin = grow(limb)
    np.testing.assert_allclose(rest_points(skin), at_rest, atol=1e-6)


def test_growing_again_moves_the_skin_to_the_anatomy(limb):
    skin = grow(limb)
    at_rest = rest_points(skin)
    skin.location = (0.0, 1.0, 0.5)
    bpy.context.view_layer.update()
    again = grow(limb)
    np.testing.assert_allclose(rest_points(again) + (0.0, 1.0, 0.5), at_rest, atol=1e-5)


def test_shape_keys_are_not_lost(limb):
    skin = grow(limb)
    count = len(skin.data.vertices)
    skin.shape_key_add(name="Basis")
    select(limb)
    with pytest.raises(RuntimeError, match="has shape keys"):
        bpy.ops.sinew.grow_skin(resolution=30)
    assert len(skin.data.vertices) == count


def test_a_too_fine_resolution_is_refused_and_changes_nothing(cat):
    before = set(bpy.data.objects.keys())
    select(cat)
    with pytest.raises(
        RuntimeError, match=r"Resolution 8000 needs about \d+ MB of memory, the limit is 2000 MB. Choose \d+ or less"
    ):
        bpy.ops.sinew.grow_skin(resolution=8000)
    assert set(bpy.data.objects.keys()) == before and not bpy.data.meshes


def test_muscles_are_not_fitted_under_a_grown_skin(cat):
    before = {found.name: tuple(found.scale) for found in bpy.data.objects if found.type == "EMPTY"}
    grow(cat)
    bpy.ops.sinew.add_preset(name="cat")
    after = {found.name: tuple(found.scale) for found in bpy.data.objects if found.name in before}
    assert before == after


def test_a_skin_that_cannot_be_bound_does_not_change(limb):
    skin = grow(limb)
    mesh = skin.data
    next(modifier for modifier in skin.modifiers if modifier.type == "ARMATURE").use_bone_envelopes = True
    select(limb)
    with pytest.raises(RuntimeError, match="Bone Envelopes"):
        bpy.ops.sinew.grow_skin(resolution=30)
    assert skin.data == mesh
    skin.modifiers.clear()
    bpy.data.objects.remove(skin)
    limb.scale = (0.0, 1.0, 1.0)
    bpy.context.view_layer.update()
    with pytest.raises(RuntimeError, match="scale of 0"):
        bpy.ops.sinew.grow_skin()
    assert not [found for found in bpy.data.objects if found.type == "MESH"]


def test_growing_without_tissues_is_refused(arm):
    _skin, rig = arm
    select(rig)
    with pytest.raises(RuntimeError, match="has no muscles"):
        bpy.ops.sinew.grow_skin()


def test_remove_takes_the_grown_skin_or_leaves_it(limb):
    skin = grow(limb)
    select(skin)
    bpy.ops.sinew.remove(keep_grown=True)
    assert skin.name in bpy.data.objects and len(skin.vertex_groups) == 2 and not skin.is_property_set("sinew")
    bpy.data.objects.remove(skin)
    bpy.context.view_layer.update()
    select(limb)
    bpy.ops.sinew.add_tissue(kind="STUFFING", origin_bone="upper")
    skin = grow(limb)
    select(skin)
    bpy.ops.sinew.remove()
    assert [found.type for found in bpy.data.objects] == ["ARMATURE"]


def test_a_grown_skin_survives_saving(limb, tmp_path):
    skin = grow(limb, resolution=50)
    count = len(skin.data.vertices)
    path = str(tmp_path / "grown.blend")
    bpy.ops.wm.save_as_mainfile(filepath=path)
    bpy.ops.wm.open_mainfile(filepath=path)
    skin = next(found for found in bpy.data.objects if found.type == "MESH")
    assert skin.sinew.skin.growth.is_grown and len(skin.data.vertices) == count
    again = grow(bpy.data.objects[skin.parent.name])
    assert again.name == skin.name and skin.sinew.skin.growth.resolution == 50


def test_skin_thickness_is_saved_in_a_musculature_file_and_mirrored(limb, tmp_path):
    empty = next(found for found in bpy.data.objects if found.name.startswith("Stuffing lower"))
    empty.sinew.tissue.skin_thickness = 0.013
    select(limb)
    path = str(tmp_path / "flesh.json")
    bpy.ops.sinew.save_musculature(filepath=path)
    empty.sinew.tissue.skin_thickness = 0.0
    bpy.ops.sinew.load_musculature(filepath=path)
    assert bpy.data.objects[empty.name].sinew.tissue.skin_thickness == pytest.approx(0.013, abs=1e-5)
