# SPDX-License-Identifier: GPL-3.0-or-later
"""Settings of the mesh and of bones: they have an effect on the live skin, and survive edits."""

import bpy
import numpy as np
import pytest
from bl_ext.user_default.sinew.live import session
from bl_ext.user_default.sinew.scene import skin_regions
from conftest import add_attribute, bend, evaluated_after_binding_again, evaluated_points, lifts, select, set_bone


def test_muscle_influence_of_a_bone_scales_its_region(bent):
    skin, rig = bent
    before = lifts(skin)
    set_bone(rig, "upper", muscle_influence=0.5)
    set_bone(rig, "lower", muscle_influence=0.5)
    assert np.allclose(lifts(skin), 0.5 * before, atol=1e-6)
    set_bone(rig, "upper", muscle_influence=0.0)
    after = lifts(skin)
    upper_alone = np.array([[element.group for element in vertex.groups] == [0] for vertex in skin.data.vertices])
    assert before[upper_alone].max() > 1e-3 and after[upper_alone].max() == 0.0 < after.max()
    assert np.array_equal(evaluated_points(skin), evaluated_after_binding_again(skin, rig))
    rig.pose.bones["upper"].property_unset("sinew")
    set_bone(rig, "lower", muscle_influence=1.0)
    assert np.array_equal(lifts(skin), before)


@pytest.mark.parametrize("name", skin_regions.OF_BONE)
def test_every_setting_of_a_bone_binds_again(bent, name):
    skin, rig = bent
    skin.sinew.skin.elastic = True
    bend(rig, 1.2)
    kept = session.cached_skin(skin)
    bend(rig, 1.1)
    assert session.cached_skin(skin) is kept
    set_bone(rig, "lower", **{name: 0.5})
    assert session.cached_skin(skin) is not kept
    assert session.cached_skin(skin).bone_settings[name].tolist() == [1.0, 0.5, 1.0]  # upper, lower and the armature


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("energy", "SPRINGS"), ("anchor_stiffness", 2.0), ("edge_stiffness", 0.5), ("slack", 0.01),
        ("fat_sliding", 0.5), ("contacts", False), ("iterations", 3), ("elastic", False),
    ],
)  # fmt: skip
def test_every_setting_of_the_mesh_binds_again(bent, name, value):
    skin, rig = bent
    skin.sinew.skin.elastic = True
    bend(rig, 1.1)
    kept = session.cached_skin(skin)
    setattr(skin.sinew.skin, name, value)
    bpy.context.view_layer.update()
    assert session.cached_skin(skin) is not kept and session.reason(skin) == ""
    assert np.isfinite(evaluated_points(skin)).all()


def test_the_joints_of_a_bendy_bone_have_its_settings(bent):
    skin, rig = bent
    rig.data.bones["lower"].bbone_segments = 3
    set_bone(rig, "lower", muscle_influence=0.0)
    factors = session.cached_rig(rig).bone_settings["muscle_influence"]
    assert factors.tolist() == [1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0]


def test_settings_survive_saving_undo_and_renaming(bent, tmp_path):
    skin, rig = bent
    plain = evaluated_points(skin)
    bpy.ops.ed.undo_push(message="bent")
    set_bone(rig, "upper", muscle_influence=0.5)
    bpy.ops.ed.undo_push(message="set")
    set_points = evaluated_points(skin)
    assert np.abs(set_points - plain).max() > 1e-4
    bpy.ops.ed.undo()
    assert np.array_equal(evaluated_points(bpy.data.objects["Arm"]), plain)
    bpy.ops.ed.redo()
    assert np.array_equal(evaluated_points(bpy.data.objects["Arm"]), set_points)
    bpy.data.objects["Arm Rig"].data.bones["upper"].name = "humerus"
    bpy.context.view_layer.update()
    assert np.array_equal(evaluated_points(bpy.data.objects["Arm"]), set_points)
    skin = bpy.data.objects["Arm"]
    add_attribute(skin, np.linspace(0.0, 1.0, len(skin.data.vertices), dtype=np.float32))
    painted_points = evaluated_points(skin)
    assert not np.array_equal(painted_points, set_points)
    path = str(tmp_path / "arm.blend")
    bpy.ops.wm.save_as_mainfile(filepath=path)
    bpy.ops.wm.open_mainfile(filepath=path)
    assert np.array_equal(evaluated_points(bpy.data.objects["Arm"]), painted_points)


def test_settings_are_copied_to_the_segment_the_selection_and_the_other_side():
    from bl_ext.user_default.sinew.scene import bone_geometry

    rig = make_rig(
        {
            "arm01.L": ((0, 0, 0), (1, 0, 0), None), "arm02.L": ((1, 0, 0), (2, 0, 0), "arm01.L"),
            "hand.L": ((2, 0, 0), (3, 0, 0), "arm02.L"), "arm01.R": ((0, 0, 0), (-1, 0, 0), None),
            "arm02.R": ((-1, 0, 0), (-2, 0, 0), "arm01.R"), "hand.R": ((-2, 0, 0), (-3, 0, 0), "arm02.R"),
        }
    )  # fmt: skip

    def settings(bone):
        own = rig.pose.bones[bone].sinew
        return own.anchor_stiffness, own.crease

    assert bone_geometry.bones_of_segment(rig, "arm02.L") == ["arm01.L", "arm02.L"]
    with pytest.raises(RuntimeError, match="Select the bone to copy from"):
        bpy.ops.sinew.copy_bone_settings()
    rig.data.bones.active = rig.data.bones["arm01.L"]
    set_bone(rig, "arm01.L", anchor_stiffness=2.0, crease=0.5)
    bpy.ops.sinew.copy_bone_settings(to="SEGMENT")
    assert settings("arm02.L") == (2.0, 0.5) and settings("hand.L") == settings("arm01.R") == (1.0, 1.0)
    bpy.ops.sinew.copy_bone_settings(to="MIRROR")
    assert settings("arm01.R") == settings("arm02.R") == (2.0, 0.5) and settings("hand.R") == (1.0, 1.0)
    deselect_all(rig)
    with pytest.raises(RuntimeError, match="Select the target bones"):
        bpy.ops.sinew.copy_bone_settings(to="SELECTED")
    bone = rig.pose.bones["hand.R"]
    (bone if hasattr(bone, "select") else bone.bone).select = True
    bpy.ops.sinew.copy_bone_settings(to="SELECTED")
    assert settings("hand.R") == (2.0, 0.5) and settings("hand.L") == (1.0, 1.0)
    rig.data.bones.active = rig.data.bones["hand.L"]
    with pytest.raises(RuntimeError, match="only bone of its segment"):
        bpy.ops.sinew.copy_bone_settings(to="SEGMENT")


def deselect_all(rig):
    for bone in rig.pose.bones:
        (bone if hasattr(bone, "select") else bone.bone).select = False


def make_rig(bones):
    armature = bpy.data.armatures.new("Rig")
    rig = bpy.data.objects.new("Rig", armature)
    bpy.context.scene.collection.objects.link(rig)
    select(rig)
    bpy.ops.object.mode_set(mode="EDIT")
    for name, (head, tail, parent) in bones.items():
        bone = armature.edit_bones.new(name)
        bone.head, bone.tail = head, tail
        bone.parent = armature.edit_bones.get(parent) if parent else None
    bpy.ops.object.mode_set(mode="OBJECT")
    armature.bones.active = None
    return rig
