# SPDX-License-Identifier: GPL-3.0-or-later
"""Clothes over a bound body: they follow its correction and keep their distance from it, live, baked and exported."""

import bpy
import _sinew
import numpy as np
import pytest
from bl_ext.user_default.sinew.live import session
from bl_ext.user_default.sinew.scene import mesh_arrays
from conftest import (
    EXTENSOR,
    FLEXOR,
    add_muscle,
    armature_alone,
    bend,
    bind,
    evaluated_points,
    key_bend,
    make_arm,
    rest_points,
    select,
)
from exports import exported
from mathutils import Matrix, Vector
from mathutils.bvhtree import BVHTree

THICKNESS = 0.004
# USD stores bone scales as 16-bit floats
MOST_MM = {".glb": 0.02, ".fbx": 0.02, ".usdc": 2.0}
ANGLES = (-1.6, -0.8, 0.5, 1.0, 1.6)  # beyond these the arm touches itself, which leaves no room for cloth in the fold


def sleeve_of(rig, name="Sleeve", thickness=THICKNESS, around=17, rings=19, weights_m=0.16, radius=0.05):
    """A tube over the arm with other vertices, and with weights that blend over another length than the arm's."""
    sleeve, other = make_arm(name, rings=rings, around=around, radius=radius + thickness)
    sleeve.parent = rig
    sleeve.modifiers["Armature"].object = rig
    bpy.data.objects.remove(other)
    for bone, sign in (("upper", -1.0), ("lower", 1.0)):
        for vertex in sleeve.data.vertices:
            weight = min(max(0.5 + sign * (vertex.co.x - 0.3) / weights_m, 0.0), 1.0)
            sleeve.vertex_groups[bone].add([vertex.index], weight, "REPLACE")
    bpy.context.view_layer.update()
    return sleeve


@pytest.fixture
def dressed(arm):
    """(body, sleeve, rig): an arm of two muscles with a sleeve, bound with one click."""
    body, rig = arm
    sleeve = sleeve_of(rig)
    add_muscle(rig, name="Flexor", around=FLEXOR)
    add_muscle(rig, name="Extensor", around=EXTENSOR)
    body.sinew.skin.muscle_influence = 3.0
    select(rig)
    bpy.ops.sinew.bind()
    return body, sleeve, rig


def tree_of(points, skin):
    return BVHTree.FromPolygons([Vector(point) for point in points], [list(face.vertices) for face in skin.data.polygons])


def heights(points, tree):
    """The signed distance of each point above a surface whose normals point outward."""
    found = []
    for point in points:
        near, normal, _index, distance = tree.find_nearest(Vector(point))
        found.append(distance if (Vector(point) - near).dot(normal) >= 0.0 else -distance)
    return np.array(found)


def assert_no_poke_through(body, sleeve, points_of_body, points_of_sleeve):
    """Every vertex of the garment keeps 95 % of its distance, or 1 mm, and no vertex of the body passes the garment."""
    inner = (rest_points(body)[:, 0] > 0.03) & (rest_points(body)[:, 0] < 0.57)
    outer = (rest_points(sleeve)[:, 0] > 0.03) & (rest_points(sleeve)[:, 0] < 0.57)
    at_rest = heights(rest_points(sleeve), tree_of(rest_points(body), body))
    posed = heights(points_of_sleeve, tree_of(points_of_body, body))
    assert (posed >= np.minimum(0.95 * at_rest, 0.001) - 1e-6)[outer].all(), posed[outer].min()
    above = heights(points_of_body, tree_of(points_of_sleeve, sleeve))
    assert (above[inner] < 1e-5).all(), above[inner].max()


def test_binding_an_armature_finds_what_is_worn_over_what(dressed):
    body, sleeve, _rig = dressed
    assert sleeve.sinew.skin.worn_over == body and body.sinew.skin.worn_over is None


def test_a_coat_is_worn_over_the_sleeve_and_a_copy_over_nothing(arm):
    body, rig = arm
    sleeve, coat = sleeve_of(rig), sleeve_of(rig, "Coat", thickness=2.5 * THICKNESS)
    apart = sleeve_of(rig, "Apart", thickness=0.2)
    add_muscle(rig, around=FLEXOR)
    select(rig)
    bpy.ops.sinew.bind()
    over = {found.name: found.sinew.skin.worn_over for found in (body, sleeve, coat, apart)}
    assert over == {"Arm": None, "Sleeve": body, "Coat": sleeve, "Apart": None}


@pytest.mark.parametrize("angle", ANGLES)
def test_a_garment_keeps_its_distance_from_the_body(dressed, angle):
    body, sleeve, rig = dressed
    bend(rig, angle)
    points_of_body = evaluated_points(body)
    assert np.abs(points_of_body - armature_alone(body)).max() > 2e-3
    assert_no_poke_through(body, sleeve, points_of_body, evaluated_points(sleeve))


def test_without_sinew_the_same_garment_would_be_poked_through(dressed):
    body, sleeve, rig = dressed
    bend(rig, 1.5)
    points_of_body = evaluated_points(body)
    with pytest.raises(AssertionError):
        assert_no_poke_through(body, sleeve, points_of_body, armature_alone(sleeve))


def test_at_rest_and_far_from_the_body_nothing_is_corrected(dressed):
    body, sleeve, rig = dressed
    assert np.abs(session.cached_skin(sleeve).correction).max() < 1e-12
    far = sleeve_of(rig, "Far", thickness=0.2)
    bind(far)
    far.sinew.skin.worn_over = body
    bend(rig, 1.0)
    assert session.reason(far) == "" and not session.cached_skin(far).correction.any()


def test_a_garment_follows_a_change_of_the_body(dressed):
    body, sleeve, rig = dressed
    bend(rig, 1.0)
    before = evaluated_points(sleeve)
    body.sinew.skin.muscle_influence = 0.0
    bpy.context.view_layer.update()
    assert np.abs(evaluated_points(sleeve) - before).max() > 1e-3


def test_a_live_garment_over_a_baked_body(dressed):
    body, sleeve, rig = dressed
    bend(rig, 1.0)
    before = evaluated_points(sleeve)
    body.sinew.skin.live = False
    bpy.context.view_layer.update()
    bpy.context.scene.frame_set(2)
    assert np.abs(evaluated_points(sleeve) - before).max() < 1e-6


def test_save_and_reload(dressed, tmp_path):
    body, sleeve, rig = dressed
    bend(rig, 1.0)
    before = evaluated_points(sleeve)
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "dressed.blend"))
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "dressed.blend"))
    assert np.abs(evaluated_points(bpy.data.objects["Sleeve"]) - before).max() < 1e-6


@pytest.mark.parametrize("case", ["unbound body", "circle", "other armature"])
def test_what_a_garment_can_not_follow_is_said_in_words(dressed, case):
    body, sleeve, rig = dressed
    bend(rig, 1.0)
    if case == "unbound body":
        select(body)
        bpy.ops.sinew.unbind()
        expected = "which is not bound"
    elif case == "circle":
        body.sinew.skin.worn_over = sleeve
        expected = "which is worn over Sleeve"
    else:
        other, second = make_arm("Other")
        add_muscle(second, around=FLEXOR)
        bind(other)
        sleeve.sinew.skin.worn_over = other
        expected = "follows another armature"
    bpy.context.view_layer.update()
    assert expected in session.reason(sleeve)
    assert np.abs(evaluated_points(sleeve) - armature_alone(sleeve)).max() < 1e-6
    sleeve.sinew.skin.worn_over = None
    body.sinew.skin.worn_over = None
    bpy.context.view_layer.update()
    assert session.reason(sleeve) == ""


# Scale and handedness

SCALES = {"even": (2.0, 2.0, 2.0), "uneven": (1.0, 1.4, 0.7), "mirrored": (-1.0, 1.0, 1.0), "hundredth": (0.01, 0.01, 0.01)}


@pytest.mark.parametrize("scale", SCALES)
@pytest.mark.parametrize("scaled", ["rig", "parent", "garment"])
def test_scaled_rigs_parents_and_garments(arm, scale, scaled):
    """The garment is as high above the body as it is without the scale, measured in the rig's axes."""
    body, rig = arm
    sleeve = sleeve_of(rig)
    if scaled == "rig":
        rig.scale = SCALES[scale]
    elif scaled == "parent":
        parent = bpy.data.objects.new("Parent", None)
        bpy.context.scene.collection.objects.link(parent)
        parent.scale, parent.rotation_euler = SCALES[scale], (0.3, 0.2, 0.5)
        rig.parent = parent
    else:
        sleeve.scale = SCALES[scale]
        sleeve.data.transform(Matrix.Diagonal((*(1.0 / each for each in SCALES[scale]), 1.0)))
    bpy.context.view_layer.update()
    add_muscle(rig, name="Flexor", around=FLEXOR)
    body.sinew.skin.muscle_influence = 3.0
    select(rig)
    bpy.ops.sinew.bind()
    assert sleeve.sinew.skin.worn_over == body
    bend(rig, 1.2)
    assert session.reason(sleeve) == "" and session.reason(body) == ""
    assert np.abs(evaluated_points(sleeve) - armature_alone(sleeve)).max() > 1e-5
    sizes = np.abs(SCALES[scale]) if scaled == "garment" else np.ones(3)
    signs = np.sign(SCALES[scale]) if scaled == "garment" else np.ones(3)
    points, rest = evaluated_points(sleeve) * sizes * signs, rest_points(sleeve) * sizes * signs
    tree, tree_at_rest = tree_of(evaluated_points(body), body), tree_of(rest_points(body), body)
    inner = (rest[:, 0] > 0.03) & (rest[:, 0] < 0.57)
    assert (heights(points, tree) >= np.minimum(0.95 * heights(rest, tree_at_rest), 0.001) - 1e-6)[inner].all()


# Baked and exported


def test_baked_keys_of_both_play_without_poke_through(dressed):
    body, sleeve, rig = dressed
    key_bend(rig, {1: 0.0, 6: 1.5})
    select(rig)
    bpy.ops.sinew.bake_shape_keys(frame_start=1, frame_end=6)
    assert not body.sinew.skin.live and not sleeve.sinew.skin.live
    bpy.context.scene.frame_set(6)
    assert_no_poke_through(body, sleeve, evaluated_points(body), evaluated_points(sleeve))


def test_correctives_of_both_are_driven_without_poke_through(dressed):
    body, sleeve, rig = dressed
    select(rig)
    bpy.ops.sinew.bake_correctives(bones="ALL", angles="Z -90..90")
    bend(rig, 1.2)
    names = [[key.name for key in skin.data.shape_keys.key_blocks] for skin in (body, sleeve)]
    assert names[0] == names[1] and len(names[0]) > 2
    assert_no_poke_through(body, sleeve, evaluated_points(body), evaluated_points(sleeve))


def test_exported_files_show_both_with_their_correctives(dressed, tmp_path):
    body, sleeve, rig = dressed
    key_bend(rig, {1: 0.0, 6: 1.2})
    scene = bpy.context.scene
    scene.frame_start, scene.frame_end = 1, 6
    select(rig)
    bpy.ops.sinew.bake_correctives(bones="ALL", angles="Z 0..70")
    frames, files = range(1, 7), []
    points = {skin.name: exported.shown(skin, frames) for skin in (body, sleeve)}
    for file_format in ("GLTF", "FBX", "USD"):
        path = tmp_path / f"dressed{exported.SUFFIXES[file_format]}"
        select(rig)
        assert bpy.ops.sinew.export(filepath=str(path), format=file_format) == {"FINISHED"}
        files += [(path, points[skin.name], skin.name) for skin in (body, sleeve)]
    for (path, _points, name), back in zip(files, exported.round_trips(files, 1), strict=True):
        assert back.missing == 0 and back.max_mm < MOST_MM[path.suffix], (path.name, name, back.max_mm)


# Faults of a garment


def faults(skin):
    """How many faces of a skin are inverted, and how many pairs of them intersect."""
    surface = _sinew.RestSurface(rest_points(skin).astype(np.float32), mesh_arrays.read_triangles(skin.data))
    deformed = surface.deformed(evaluated_points(skin).astype(np.float32))
    return int(deformed.inverted.sum()), len(deformed.new_intersections)


@pytest.mark.parametrize("angle", ANGLES)
def test_a_garment_has_no_more_faults_than_with_its_modifier_alone(dressed, angle):
    _body, sleeve, rig = dressed
    bend(rig, angle)
    inverted, intersections = faults(sleeve)
    sleeve.sinew.skin.live = False
    bpy.context.view_layer.update()
    alone = faults(sleeve)
    assert inverted <= alone[0] + 1 and intersections <= max(alone[1] + 1, 1.02 * alone[1])
