# SPDX-License-Identifier: GPL-3.0-or-later
"""Muscles from a preset: their positions on Rigify's metarig and on the MakeHuman body, and fitting."""

import itertools
import math
from dataclasses import replace

import bpy
import numpy as np
import pytest
from bl_ext.user_default.sinew.errors import SinewError
from bl_ext.user_default.sinew.muscles import mirror
from bl_ext.user_default.sinew.muscles.placing.fit import fit
from bl_ext.user_default.sinew.muscles.placing.fit.skin_surface import SkinSurface
from bl_ext.user_default.sinew.muscles.placing.place import placement, preset_file
from bl_ext.user_default.sinew.muscles.placing.recognise import segments
from bl_ext.user_default.sinew.scene import characters, mesh_arrays, tissue_empty
from conftest import select
from mathutils import Matrix, Quaternion, Vector

pytestmark = pytest.mark.one_blender

MUSCLES_A_SIDE = 29
SPHERES_A_SIDE = 6
TUBE_RADIUS_OF_LENGTH = 0.2
LIMBS = (("upper_arm", "forearm"), ("thigh", "shin"))

ACROSS = Matrix.Diagonal((-1.0, 1.0, 1.0))  # from one side of the body to the other


@pytest.fixture
def metarig(rigify):
    """Rigify's human metarig: 2 m tall, arms out, elbows slightly bent."""
    bpy.ops.object.armature_human_metarig_add()
    return bpy.context.object


def limbs(rig, skin=None):
    """The shipped preset on a rig, fitted if there is a skin."""
    shapes = placement.place(preset_file.read("limbs"), segments.recognise(rig), skin)
    return [fit.fit(shape, skin) for shape in shapes] if skin else shapes


def tubes(rig, around=18):
    """A closed tube around each limb, in one mesh. The tubes of the thighs overlap."""
    body = segments.recognise(rig)
    angles_deg = np.linspace(0.0, 360.0, around, endpoint=False)
    points, faces = [], []
    for limb, side in itertools.product(LIMBS, "LR"):
        first = len(points)
        radius_m = TUBE_RADIUS_OF_LENGTH * body.segment(limb[0], side).length
        for role, stations in zip(limb, (np.linspace(-0.3, 0.85, 9), np.linspace(0.15, 1.2, 9)), strict=True):
            segment = body.segment(role, side)
            for along, angle_deg in itertools.product(stations, angles_deg):
                points.append(segment.point(along) + segment.direction(angle_deg) * radius_m)
        corners = np.arange(first, len(points)).reshape(-1, around)
        ahead = np.roll(corners, -1, axis=1)
        walls = np.stack((corners[:-1], ahead[:-1], ahead[1:], corners[1:]), axis=2).reshape(-1, 4).tolist()
        tube = [*walls, corners[0, ::-1].tolist(), corners[-1].tolist()]
        faces += tube if side == "L" else [face[::-1] for face in tube]
    mesh = bpy.data.meshes.new("Tubes")
    mesh.from_pydata(points, [], faces)
    skin = bpy.data.objects.new("Tubes", mesh)
    bpy.context.scene.collection.objects.link(skin)
    return skin


def mirrored(point):
    return Vector((-point.x, point.y, point.z))


def asymmetry_m(rig):
    """The largest distance between an end of a left bone and the mirrored end of its right twin.

    Shapes cannot be more symmetric than the rig: the fingers of Rigify's human metarig differ by 0.1 mm in Blender 4.5.
    Their bones are 1 cm long or longer, so directions differ by a hundred times as much, and points beside them by twice
    as much.
    """
    bones = rig.data.bones
    return max(
        (mirrored(here) - there).length
        for bone in bones
        if bone.name.endswith(".L")
        for twin in (bones[bone.name.removesuffix(".L") + ".R"],)
        for here, there in ((bone.head_local, twin.head_local), (bone.tail_local, twin.tail_local))
    )


def assert_mirrored(shapes, tolerance_m, tolerance_of_direction=1e-3):
    by_name = {shape.name: shape for shape in shapes}
    for left in (shape for shape in shapes if shape.name.endswith(".L")):
        right = by_name[left.name.removesuffix(".L") + ".R"]
        for there, here in (
            (right.centre, left.centre),
            (right.origin, left.origin),
            (right.insertion, left.insertion),
        ):
            assert (there - mirrored(here)).length < tolerance_m, left.name
        assert (right.semi_axes - left.semi_axes).length < tolerance_m, left.name
        out_left, out_right = (shape.rotation @ Vector((1, 0, 0)) for shape in (left, right))
        assert (out_right - mirrored(out_left)).length < tolerance_of_direction, left.name
        assert right.origin_bone == left.origin_bone.replace(".L", ".R")
        assert right.insertion_bone == left.insertion_bone.replace(".L", ".R")


def assert_whole(shapes, rig):
    muscles = [shape for shape in shapes if shape.kind == "MUSCLE"]
    spheres = [shape for shape in shapes if shape.kind == "SPHERE"]
    assert len(muscles) == 2 * MUSCLES_A_SIDE
    assert len(spheres) == 2 * SPHERES_A_SIDE
    assert len({shape.name for shape in shapes}) == len(shapes)
    for shape in shapes:
        assert min(shape.semi_axes) > 0.0
        assert shape.origin_bone in rig.data.bones
        assert shape.insertion_bone in rig.data.bones
        assert abs(shape.rotation.magnitude - 1.0) < 1e-5
    for sphere in spheres:
        assert sphere.origin_bone == sphere.insertion_bone


def farthest_out(shapes, skin):
    return max((fit.protrusion(shape, skin), shape.name) for shape in shapes)


def vertices_inside(shape, points):
    """The number of skin vertices inside the ellipsoid. It tests `fit` without rays."""
    to_local = np.array(shape.rotation.to_matrix()).T
    scaled = (points - np.array(shape.centre)) @ to_local.T / np.array(shape.semi_axes)
    return int((np.linalg.norm(scaled, axis=1) < 1.0).sum())


def length_over(shapes, name, rig, moving_bone, hinge, degrees):
    """|I - O| of a muscle with one joint rotated from the rest pose, and all bones below it rigid."""
    shape = next(shape for shape in shapes if shape.name == name)
    bone = rig.data.bones[moving_bone]
    beyond = {bone.name, *(child.name for child in bone.children_recursive)}
    turn = Matrix.Translation(bone.head_local) @ Quaternion(hinge, math.radians(degrees)).to_matrix().to_4x4()
    turn = turn @ Matrix.Translation(-bone.head_local)
    origin = turn @ shape.origin if shape.origin_bone in beyond else shape.origin
    insertion = turn @ shape.insertion if shape.insertion_bone in beyond else shape.insertion
    return (insertion - origin).length


def changes(shapes, name, rig, moving_bone, hinge, degrees):
    return np.diff([length_over(shapes, name, rig, moving_bone, hinge, angle) for angle in degrees])


# Bodies


def test_the_metarig_without_a_skin(metarig):
    shapes = limbs(metarig)
    assert_whole(shapes, metarig)
    assert_mirrored(shapes, 1e-5)


def test_the_real_body(real_body):
    mesh, rig = real_body
    skin = SkinSurface.of(mesh, rig)
    shapes = limbs(rig, skin)
    assert_whole(shapes, rig)
    assert_mirrored(shapes, 1e-5)
    assert min(min(shape.semi_axes) for shape in shapes) > 0.007
    farthest_m, name = farthest_out(shapes, skin)
    print(f"farthest out of the skin: {farthest_m * 1000:.3f} mm ({name})")
    assert farthest_m < 1e-4, name


def test_no_skin_vertex_is_inside_a_belly(real_body):
    mesh, rig = real_body
    points = np.array([vertex.co for vertex in mesh.data.vertices])
    swallowed = {shape.name: vertices_inside(shape, points) for shape in limbs(rig, SkinSurface.of(mesh, rig))}
    assert not any(swallowed.values()), {name: count for name, count in swallowed.items() if count}


@pytest.mark.parametrize("muscle", ["Biceps brachii", "Rectus femoris", "Vastus lateralis", "Gastrocnemius, medial head"])
def test_a_superficial_belly_is_near_the_skin(real_body, muscle):
    mesh, rig = real_body
    skin = SkinSurface.of(mesh, rig)
    shape = next(shape for shape in limbs(rig, skin) if shape.name == f"{muscle}.L")
    surface = shape.centre + shape.rotation @ Vector((shape.semi_axes.x, 0, 0))
    assert skin.nearest_distance(surface) < 0.008


def test_tubes_around_a_metarig(metarig):
    skin = SkinSurface.of(tubes(metarig), metarig)
    shapes = limbs(metarig, skin)
    assert_whole(shapes, metarig)
    in_tubes = [shape for shape in shapes if skin.is_inside(shape.origin) and skin.is_inside(shape.insertion)]
    assert len(in_tubes) > MUSCLES_A_SIDE
    assert_mirrored(in_tubes, 1e-5)
    farthest_m, name = farthest_out(in_tubes, skin)
    assert farthest_m < 5e-4, name


def test_fitting_twice_changes_nothing(real_body):
    mesh, rig = real_body
    skin = SkinSurface.of(mesh, rig)
    for shape in limbs(rig, skin):
        again = fit.fit(shape, skin)
        assert (again.centre - shape.centre).length < 1e-5, shape.name
        assert (again.semi_axes - shape.semi_axes).length < 1e-5, shape.name


def test_a_too_thick_belly_shrinks(real_body):
    mesh, rig = real_body
    skin = SkinSurface.of(mesh, rig)
    biceps = next(shape for shape in limbs(rig, skin) if shape.name == "Biceps brachii.L")
    swollen = replace(biceps, semi_axes=Vector((0.06, 0.06, biceps.semi_axes.z)))
    assert fit.protrusion(swollen, skin) > 0.005
    assert fit.protrusion(fit.fit(swollen, skin), skin) == 0.0


def test_a_belly_without_skin_over_it_does_not_change(metarig):
    skin = SkinSurface.of(tubes(metarig), metarig)
    biceps = next(shape for shape in limbs(metarig) if shape.name == "Biceps brachii.L")
    elsewhere = replace(biceps, centre=biceps.centre + Vector((0, -1, 0)))
    assert fit.fit(elsewhere, skin) == elsewhere


def test_the_object_transform_and_the_pose_do_not_matter(metarig):
    before = limbs(metarig)
    metarig.matrix_world = Matrix.LocRotScale((3, -2, 1), Quaternion((1, 2, 3), 1.0), (0.1, 2.0, 5.0))
    metarig.pose.bones["forearm.L"].rotation_mode = "XYZ"
    metarig.pose.bones["forearm.L"].rotation_euler = (1.0, 0.0, 0.0)
    bpy.context.view_layer.update()
    for was, now in zip(before, limbs(metarig), strict=True):
        assert (was.centre - now.centre).length < 1e-6
        assert (was.semi_axes - now.semi_axes).length < 1e-6


def test_a_moved_mesh_is_read_in_armature_space(real_body):
    mesh, rig = real_body
    before = limbs(rig, SkinSurface.of(mesh, rig))
    mesh.parent = None
    together = Matrix.LocRotScale((3, -2, 1), Quaternion((1, 2, 3), 1.0), (10.0, 10.0, 10.0))
    rig.matrix_world, mesh.matrix_world = together @ rig.matrix_world, together @ mesh.matrix_world
    bpy.context.view_layer.update()
    for was, now in zip(before, limbs(rig, SkinSurface.of(mesh, rig)), strict=True):
        assert (was.centre - now.centre).length < 1e-4, was.name
        assert (was.semi_axes - now.semi_axes).length < 1e-4, was.name


def test_inverted_normals_change_nothing(real_body):
    mesh, rig = real_body
    before = limbs(rig, SkinSurface.of(mesh, rig))
    mesh.data.flip_normals()
    for was, now in zip(before, limbs(rig, SkinSurface.of(mesh, rig)), strict=True):
        assert (was.semi_axes - now.semi_axes).length < 1e-5, was.name


def test_the_skin_is_the_shown_shape(real_body):
    mesh, rig = real_body
    size_m = SkinSurface.of(mesh, rig).size_m
    mesh.shape_key_add(name="Basis")
    key = mesh.shape_key_add(name="Tall")
    key.value = 0.0
    key.points.foreach_set("co", 1.5 * mesh_arrays.read_points(mesh.data).reshape(-1))
    assert SkinSurface.of(mesh, rig).size_m == pytest.approx(size_m)
    key.value = 1.0
    assert SkinSurface.of(mesh, rig).size_m == pytest.approx(1.5 * size_m)


# Segments


def test_segment_axes_have_anatomical_directions(metarig):
    body = segments.recognise(metarig)
    for role, side in itertools.product(("upper_arm", "forearm", "thigh", "shin"), "LR"):
        segment = body.segment(role, side)
        outer_x = segment.outer.x if side == "L" else -segment.outer.x
        assert outer_x > 0 or segment.outer.z > 0.5, role
        assert segment.front.y < 0, role
        assert abs(segment.front.dot(segment.axis)) < 1e-5
    assert body.segment("shoulder_girdle", "L").outer.z > 0.9
    assert body.segment("foot", "R").front.z > 0.5
    assert body.segment("pelvis", "L").outer.x > 0.9
    assert body.segment("pelvis", "R").outer.x < -0.9


def test_split_bones_are_one_segment(real_body):
    _, rig = real_body
    forearm = segments.recognise(rig).segment("forearm", "L")
    assert forearm.bones == ("lowerarm01.L", "lowerarm02.L")
    assert forearm.bone_at(0.0) == forearm.bone_at(-0.2) == "lowerarm01.L"
    assert forearm.bone_at(0.9) == forearm.bone_at(1.2) == "lowerarm02.L"


def test_a_missing_bone_is_named(metarig):
    metarig.data.bones["forearm.L"].name = "lost"
    body = segments.recognise(metarig)
    with pytest.raises(SinewError, match=r"Rigify human.*forearm L is missing.*'forearm\.L'.*table Bones.*Add Tissue"):
        placement.place(preset_file.read("limbs"), body, None)


def test_an_unknown_rig_is_refused_with_the_known_kinds(arm):
    _, rig = arm
    with pytest.raises(SinewError, match="isn't a rig that Sinew knows.*MakeHuman.*Rigify"):
        segments.recognise(rig)


def test_no_armature():
    with pytest.raises(SinewError, match="An armature is needed"):
        segments.recognise(None)


# Lengths over a joint


ELBOW_DEG = range(0, 104, 4)  # the elbow is at 46 degrees at rest: from 46 to 150
KNEE_DEG = range(0, 120, 4)


@pytest.mark.parametrize(
    ("muscle", "least", "most"),
    [
        ("Biceps brachii", -0.4, -0.15),
        ("Brachialis", -0.4, -0.15),
        ("Triceps brachii, long head", 0.05, 0.4),
        ("Triceps brachii, lateral head", 0.05, 0.4),
        ("Triceps brachii, medial head", 0.05, 0.4),
    ],
)
def test_elbow_flexion(real_body, muscle, least, most):
    mesh, rig = real_body
    shapes = limbs(rig, SkinSurface.of(mesh, rig))
    forearm = segments.recognise(rig).segment("forearm", "L")
    rest, bent = (length_over(shapes, f"{muscle}.L", rig, "lowerarm01.L", flexion_axis(forearm), angle) for angle in (0, 74))
    assert least < bent / rest - 1 < most
    steps = changes(shapes, f"{muscle}.L", rig, "lowerarm01.L", flexion_axis(forearm), ELBOW_DEG)
    assert (np.sign(steps) == np.sign(least + most)).all()


@pytest.mark.parametrize(
    ("muscle", "sign"),
    [
        ("Rectus femoris", 1),
        ("Vastus lateralis", 1),
        ("Vastus medialis", 1),
        ("Biceps femoris", -1),
        ("Semitendinosus", -1),
    ],
)
def test_knee_flexion(real_body, muscle, sign):
    mesh, rig = real_body
    shapes = limbs(rig, SkinSurface.of(mesh, rig))
    shin = segments.recognise(rig).segment("shin", "L")
    steps = changes(shapes, f"{muscle}.L", rig, "lowerleg01.L", -flexion_axis(shin), KNEE_DEG)
    assert (np.sign(steps) == sign).all()


def flexion_axis(segment):
    """The axis about which a rotation moves the segment toward its front."""
    return segment.axis.cross(segment.front)


def test_a_mesh_without_faces(metarig):
    empty = bpy.data.objects.new("Empty", bpy.data.meshes.new("Empty"))
    with pytest.raises(SinewError, match="'Empty' has no faces"):
        SkinSurface.of(empty, metarig)


def test_fitting_keeps_left_and_right_mirrored(real_body):
    _, rig = real_body
    select(rig)
    bpy.ops.sinew.add_preset(name="human", fit_skin=False)
    select(rig)
    bpy.ops.sinew.fit()
    shapes = {shape.name: shape for shape in (tissue_empty.read(empty, rig) for empty in characters.tissues_of(rig))}
    for name in filter(lambda name: name.endswith(".L"), shapes):
        left, right = shapes[name], shapes[mirror.flipped(name)]
        assert (ACROSS @ left.centre - right.centre).length < 1e-5, name
        assert (left.semi_axes - right.semi_axes).length < 1e-5, name
