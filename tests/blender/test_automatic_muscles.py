# SPDX-License-Identifier: GPL-3.0-or-later
"""Automatic muscles: four for each joint, on an arm, a fish and a robot."""

import bpy
import numpy as np
import pytest
from bl_ext.user_default.sinew.scene import characters, tissue_empty
from conftest import bend, bind, evaluated_points, select
from mathutils import Vector


@pytest.fixture
def fish():
    """A fish of seven bones in a row, with a pair of fins and a bone that is too small for muscles."""
    data = bpy.data.armatures.new("Fish")
    rig = bpy.data.objects.new("Fish", data)
    bpy.context.scene.collection.objects.link(rig)
    bpy.context.view_layer.objects.active = rig
    bpy.ops.object.mode_set(mode="EDIT")
    above = None
    for number in range(7):
        bone = data.edit_bones.new(f"spine.{number:03d}")
        bone.head, bone.tail, bone.parent = (0, 0.1 * number, 0), (0, 0.1 * number + 0.1, 0), above
        above = bone
    for side, sign in (("L", 1), ("R", -1)):
        fin = data.edit_bones.new(f"fin.{side}")
        fin.head, fin.tail, fin.parent = (0.03 * sign, 0.2, 0), (0.13 * sign, 0.28, -0.02), data.edit_bones["spine.001"]
    eye = data.edit_bones.new("eye")
    eye.head, eye.tail, eye.parent = (0, 0.02, 0.02), (0, 0.02, 0.025), data.edit_bones["spine.000"]
    bpy.ops.armature.select_all(action="SELECT")
    bpy.ops.armature.calculate_roll(type="GLOBAL_POS_Z")
    bpy.ops.object.mode_set(mode="OBJECT")
    select(rig)
    return rig


def shapes_of(rig):
    return {empty.name: tissue_empty.read(empty, rig) for empty in characters.tissues_of(rig)}


def test_four_muscles_for_one_joint(arm):
    _, rig = arm
    select(rig)
    bpy.ops.sinew.add_automatic(fit_skin=False)
    shapes = shapes_of(rig)
    assert set(shapes) == {"Flexor lower", "Extensor lower", "Abductor lower", "Adductor lower"}
    for shape in shapes.values():
        assert (shape.origin_bone, shape.insertion_bone) == ("upper", "lower")
        assert shape.origin.x == pytest.approx(0.03, abs=1e-6)
        assert shape.insertion.x == pytest.approx(0.33, abs=1e-6)
        assert Vector(shape.origin[1:]).length == pytest.approx(0.12 * 0.3, abs=1e-6)
    middle = sum((shape.centre for shape in shapes.values()), Vector()) / 4
    assert Vector(middle[1:]).length < 1e-6


def test_along_gamma_and_kinds(arm):
    _, rig = arm
    select(rig)
    bpy.ops.sinew.add_automatic(fit_skin=False, kinds={"FLEXOR", "EXTENSOR"}, along=0.3, gamma=0.05)
    shapes = shapes_of(rig)
    assert set(shapes) == {"Flexor lower", "Extensor lower"}
    flexor = shapes["Flexor lower"]
    assert flexor.origin.x == pytest.approx(0.09, abs=1e-6)
    assert Vector(flexor.origin[1:]).length == pytest.approx(0.015, abs=1e-6)


def test_automatic_muscles_are_fitted_under_the_skin(arm):
    from bl_ext.user_default.sinew.muscles.placing.fit import fit
    from bl_ext.user_default.sinew.muscles.placing.fit.skin_surface import SkinSurface

    mesh, rig = arm
    select(rig)
    bpy.ops.sinew.add_automatic(gamma=0.13)
    skin = SkinSurface.of(mesh, rig)
    assert all(fit.protrusion(shape, skin) == 0.0 for shape in shapes_of(rig).values())


def test_a_fish(fish):
    bpy.ops.sinew.add_automatic()
    shapes = shapes_of(fish)
    assert len(shapes) == 4 * (6 + 2)
    assert {"Flexor spine.003", "Abductor spine.003.L", "Abductor spine.003.R", "Adductor fin.L"} < set(shapes)
    assert not any("eye" in name for name in shapes)
    for name, left in shapes.items():
        if name.endswith(".L"):
            right = shapes[name.removesuffix("L") + "R"]
            assert (Vector((-left.centre.x, *left.centre[1:])) - right.centre).length < 1e-5
    assert shapes["Abductor fin.L"].centre.x > shapes["Adductor fin.L"].centre.x


def test_a_flexor_shortens_as_its_joint_bends(real_body):
    _, rig = real_body
    select(rig)
    bpy.ops.object.mode_set(mode="POSE")
    for bone in rig.pose.bones:
        chosen = bone.name == "lowerarm01.L"
        if hasattr(bone, "select"):
            bone.select = chosen
        else:
            bone.bone.select = chosen
    bpy.ops.sinew.add_automatic(scope="SELECTED")
    shapes = shapes_of(rig)
    assert set(shapes) == {f"{kind} lowerarm01.L" for kind in ("Flexor", "Extensor", "Abductor", "Adductor")}
    flexor, extensor = shapes["Flexor lowerarm01.L"], shapes["Extensor lowerarm01.L"]
    assert flexor.insertion.y < extensor.insertion.y  # an elbow bends forward


def test_skin_follows_automatic_muscles(arm):
    mesh, rig = arm
    select(rig)
    bpy.ops.sinew.add_automatic(gamma=0.11)
    bind(mesh)
    before = evaluated_points(mesh)
    bend(rig, 1.2)
    assert np.isfinite(evaluated_points(mesh)).all()
    assert np.abs(evaluated_points(mesh) - before).max() > 0.05


def test_every_metarig_of_rigify_gets_muscles(rigify):
    for name in ("armature_horse_metarig_add", "armature_bird_metarig_add", "armature_shark_metarig_add"):
        if name in dir(bpy.ops.object):
            getattr(bpy.ops.object, name)()
            rig = bpy.context.object
            bpy.ops.sinew.add_automatic()
            shapes = shapes_of(rig)
            assert len(shapes) > 40, name
            assert all(min(shape.semi_axes) > 0 for shape in shapes.values())


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"scope": "SELECTED"}, "No bone is selected"),
        ({"kinds": set()}, "No muscle is chosen"),
        ({"shortest_bone": 2.0}, "no joint was found"),
    ],
)
def test_impossible_requests_are_reported(arm, settings, message):
    _, rig = arm
    select(rig)
    with pytest.raises(RuntimeError, match=message):
        bpy.ops.sinew.add_automatic(**settings)


def test_one_bone_has_no_joint():
    bpy.ops.object.armature_add()
    assert not bpy.ops.sinew.add_automatic.poll()
