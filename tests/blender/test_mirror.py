# SPDX-License-Identifier: GPL-3.0-or-later
"""Mirroring tissues from one side of a rig to the other."""

import math

import bpy
import pytest
from bl_ext.user_default.sinew.muscles import edit, mirror
from bl_ext.user_default.sinew.scene import characters, tissue_empty
from conftest import add_muscle, delete_in_viewport, problems_of, select, tissue_names
from mathutils import Matrix, Quaternion, Vector

ACROSS = Matrix.Diagonal((-1.0, 1.0, 1.0))


def make_rig(bones):
    """A rig from (name, head, tail, roll, parent) of each bone."""
    armature = bpy.data.armatures.new("Twins")
    rig = bpy.data.objects.new("Twins", armature)
    bpy.context.scene.collection.objects.link(rig)
    bpy.context.view_layer.objects.active = rig
    bpy.ops.object.mode_set(mode="EDIT")
    for name, head, tail, roll, parent in bones:
        bone = armature.edit_bones.new(name)
        bone.head, bone.tail, bone.roll = head, tail, roll
        bone.parent = armature.edit_bones.get(parent)
    bpy.ops.object.mode_set(mode="OBJECT")
    return rig


def twins(left="arm.L", right="arm.R", right_roll=-0.7, right_tail=(-0.5, 0.1, 1.2)):
    return make_rig(
        (
            ("spine", (0, 0, 0), (0, 0, 1), 0.0, ""),
            (left, (0.1, 0, 1), (0.5, 0.1, 1.2), 0.7, "spine"),
            (right, (-0.1, 0, 1), right_tail, right_roll, "spine"),
        )
    )


def muscle(rig, name, origin="spine", insertion="arm.L", **settings):
    shape = tissue_empty.TissueShape(
        name=name,
        kind="MUSCLE",
        origin_bone=origin,
        insertion_bone=insertion,
        centre=Vector((0.15, -0.05, 0.8)),
        rotation=Quaternion((0.9, 0.2, 0.3, -0.1)).normalized(),
        semi_axes=Vector((0.02, 0.04, 0.15)),
        origin_tendon=0.03,
        insertion_tendon=0.05,
        volume_keeping=0.8,
        **settings,
    )
    return edit.add(rig, [shape])[0]


def assert_mirrored(rig, left, right, within=1e-5):
    own, twin = tissue_empty.read(left, rig), tissue_empty.read(right, rig)
    assert (ACROSS @ own.origin - twin.origin).length < within
    assert (ACROSS @ own.insertion - twin.insertion).length < within
    assert (own.semi_axes - twin.semi_axes).length < within
    for axis in ((1, 0, 0), (0, 1, 0)):
        along = (ACROSS @ (own.rotation @ Vector(axis))).dot(twin.rotation @ Vector(axis))
        assert abs(along) > 1 - 1e-5
    assert abs(own.origin_tendon - twin.origin_tendon) < within
    assert abs(own.insertion_tendon - twin.insertion_tendon) < within
    assert twin.volume_keeping == own.volume_keeping
    assert (mirror.flipped(own.origin_bone), mirror.flipped(own.insertion_bone)) == (
        twin.origin_bone,
        twin.insertion_bone,
    )


@pytest.mark.parametrize(
    ("left", "right"),
    [("arm.L", "arm.R"), ("arm_l", "arm_r"), ("LeftArm", "RightArm"), ("L_arm", "R_arm"), ("arm.L.001", "arm.R.001")],
)
@pytest.mark.parametrize("right_roll", [-0.7, 0.4])
def test_a_twin_is_created(left, right, right_roll):
    """With any roll of the twin bone: if the ends of the bones are mirror images, so are the tissues."""
    rig = twins(left, right, right_roll)
    own = muscle(rig, "Deltoid.L", insertion=left)
    own.sinew.tissue.tension = 0.25
    select(own)
    bpy.ops.sinew.mirror()
    twin = bpy.data.objects["Deltoid.R"]
    assert twin.sinew.tissue.insertion_bone == right and twin.sinew.tissue.tension == 0.25
    assert_mirrored(rig, own, twin)


def test_sides_of_names_follow_blenders_flip_names():
    sides = [mirror.side_of_name(name) for name in ("a.L", "a_r", "Left Arm", "R_a", "a.L.001", "Lateral", "rib", "")]
    assert sides == ["L", "R", "L", "R", "L", "", "", ""]


def test_a_twin_is_replaced_and_stays_the_same_object():
    rig = twins()
    own, twin = muscle(rig, "Deltoid.L"), muscle(rig, "Deltoid.R", insertion="arm.R")
    twin["mine"] = 1
    twin.keyframe_insert("sinew.tissue.tension", frame=1)
    select(own)
    bpy.ops.sinew.mirror()
    assert len(characters.tissues_of(rig)) == 2 and bpy.data.objects["Deltoid.R"]["mine"] == 1
    assert_mirrored(rig, own, bpy.data.objects["Deltoid.R"])


def test_mirroring_twice_gives_the_first_position():
    rig = twins()
    own = muscle(rig, "Deltoid.L")
    before = tissue_empty.read(own, rig)
    select(own)
    bpy.ops.sinew.mirror(direction="LEFT_TO_RIGHT")
    bpy.ops.sinew.mirror(direction="RIGHT_TO_LEFT")
    after = tissue_empty.read(own, rig)
    assert (before.centre - after.centre).length < 1e-6 and (before.semi_axes - after.semi_axes).length < 1e-6


def test_the_centre_line_stays_single():
    rig = twins()
    muscle(rig, "Sternum", insertion="spine")
    muscle(rig, "Across", origin="arm.L", insertion="arm.R")
    muscle(rig, "Deltoid.L")
    select(rig)
    bpy.ops.sinew.mirror(direction="LEFT_TO_RIGHT")
    assert [empty.name for empty in characters.tissues_of(rig)] == ["Across", "Deltoid.L", "Deltoid.R", "Sternum"]


def test_a_name_without_side_gets_its_side():
    rig = twins()
    select(muscle(rig, "Deltoid"))
    bpy.ops.sinew.mirror()
    assert [empty.name for empty in characters.tissues_of(rig)] == ["Deltoid.L", "Deltoid.R"]
    bpy.ops.sinew.mirror(direction="RIGHT_TO_LEFT")
    assert len(characters.tissues_of(rig)) == 2


def test_the_active_tissue_of_a_selected_pair_is_kept():
    rig = twins()
    left, right = muscle(rig, "Deltoid.L"), muscle(rig, "Deltoid.R", insertion="arm.R")
    right.location.x -= 0.3
    wanted = tissue_empty.read(right, rig).centre
    select(right, left)
    bpy.ops.sinew.mirror()
    assert (tissue_empty.read(right, rig).centre - wanted).length < 1e-7
    assert_mirrored(rig, left, right)


def test_a_rig_that_is_not_symmetric_mirrors_by_its_bones():
    """The right arm is longer and bent at another point. The twin is at the same place on it as the tissue on the left."""
    rig = twins(right_tail=(-0.5, 0.9, 1.9), right_roll=0.3)
    own = muscle(rig, "Forearm.L", origin="arm.L")
    select(own)
    bpy.ops.sinew.mirror()
    twin = tissue_empty.read(bpy.data.objects["Forearm.R"], rig)
    own = tissue_empty.read(own, rig)
    bones = rig.data.bones
    growth = bones["arm.R"].length / bones["arm.L"].length
    in_left = bones["arm.L"].matrix_local.inverted() @ own.origin
    in_right = bones["arm.R"].matrix_local.inverted() @ twin.origin
    assert (ACROSS @ in_left * growth - in_right).length < 1e-5
    assert abs(twin.semi_axes.x - own.semi_axes.x * growth) < 1e-5


def test_a_posed_rotated_rig_mirrors_in_its_rest_pose():
    rig = twins()
    own = muscle(rig, "Deltoid.L")
    rig.rotation_euler = (0.3, 0.4, 0.5)
    rig.pose.bones["arm.L"].rotation_quaternion = Quaternion((0, 0, 1), 1.0)
    bpy.context.view_layer.update()
    select(own)
    bpy.ops.sinew.mirror()
    assert_mirrored(rig, own, bpy.data.objects["Deltoid.R"])


def test_rigid_kinds_mirror_too(arm):
    rig = twins()
    select(rig)
    for kind in ("BONE", "STUFFING", "SPHERE"):
        bpy.ops.sinew.add_tissue(kind=kind, origin_bone="arm.L", name=f"{kind}.L")
    bpy.ops.sinew.mirror(direction="LEFT_TO_RIGHT")
    for kind in ("BONE", "STUFFING", "SPHERE"):
        twin = bpy.data.objects[f"{kind}.R"]
        assert twin.sinew.tissue.kind == kind
        assert_mirrored(rig, bpy.data.objects[f"{kind}.L"], twin)


def test_via_points_and_wraps_are_mirrored():
    rig = twins()
    shape = mirror.twin_shape(
        tissue_empty.TissueShape(
            "Deltoid.L", "MUSCLE", "spine", "arm.L", Vector((0.2, 0, 1)), Quaternion(), Vector((0.02, 0.02, 0.1)),
            via_points=(("arm.L", Vector((0.3, 0.1, 1.1))), ("spine", Vector((0.02, 0.1, 0.9)))), wraps=("Shoulder.L",),
        ),
        rig,
    )  # fmt: skip
    assert [bone for bone, _ in shape.via_points] == ["arm.R", "spine"] and shape.wraps == ("Shoulder.R",)
    assert (shape.via_points[0][1] - Vector((-0.3, 0.1, 1.1))).length < 1e-6


curved = pytest.mark.skipif(not hasattr(bpy.types, "SINEW_OT_wrap"), reason="this Sinew has no curved muscles")


@curved
def test_curved_muscles_get_curved_twins():
    rig = twins()
    select(rig)
    bpy.ops.sinew.add_tissue(kind="SPHERE", origin_bone="arm.L", name="Ball.L")
    own = muscle(
        rig,
        "Deltoid.L",
        via_points=(("arm.L", Vector((0.3, 0.1, 1.1))), ("spine", Vector((0.1, 0.1, 0.9)))),
        wraps=("Ball.L",),
    )
    for _ in range(2):
        select(rig)
        bpy.ops.sinew.mirror(direction="LEFT_TO_RIGHT")
        left, right = tissue_empty.read(own, rig), tissue_empty.read(bpy.data.objects["Deltoid.R"], rig)
        assert right.wraps == ("Ball.R",) and [bone for bone, _ in right.via_points] == ["arm.R", "spine"]
        for (_, point), (_, twin) in zip(left.via_points, right.via_points):
            assert (ACROSS @ point - twin).length < 1e-5


def test_a_missing_twin_bone_is_named(arm):
    _skin, rig = arm
    rig.data.bones["lower"].name = "lower.L"
    select(add_muscle(rig, insertion_bone="lower.L", name="Biceps.L"))
    with pytest.raises(RuntimeError, match=r"no bone 'lower.R', the twin of 'lower.L'"):
        bpy.ops.sinew.mirror()
    assert len(characters.tissues_of(rig)) == 1


def test_nothing_selected_says_what_to_do(arm):
    _skin, rig = arm
    add_muscle(rig)
    select(rig)
    with pytest.raises(RuntimeError, match="Select the muscles to mirror"):
        bpy.ops.sinew.mirror()


def test_the_preset_and_mirror_give_the_same_tissues_on_the_real_body(real_body):
    _skin, rig = real_body
    select(rig)
    bpy.ops.sinew.add_preset(name="limbs")
    left = [empty.name for empty in characters.tissues_of(rig) if empty.name.endswith(".L")]
    bpy.ops.sinew.mirror(direction="LEFT_TO_RIGHT")
    assert len(characters.tissues_of(rig)) == 2 * len(left)
    for name in left:
        assert_mirrored(rig, bpy.data.objects[name], bpy.data.objects[mirror.flipped(name)])


def test_undo(arm):
    rig = twins()
    select(muscle(rig, "Deltoid.L"))
    bpy.ops.ed.undo_push(message="muscle")
    bpy.ops.sinew.mirror()
    bpy.ops.ed.undo_push(message="mirror")
    bpy.ops.ed.undo()
    assert "Deltoid.R" not in bpy.data.objects
    bpy.ops.ed.redo()
    assert "Deltoid.R" in bpy.data.objects and math.isclose(
        bpy.data.objects["Deltoid.R"].sinew.tissue.volume_keeping, 0.8, abs_tol=1e-6
    )


def test_mirror_restores_a_deleted_muscle(human):
    delete_in_viewport("Sartorius.R")
    assert "Sartorius.R" not in tissue_names(human)
    select(bpy.data.objects["Sartorius.L"])
    bpy.ops.sinew.mirror()
    assert "Sartorius.R" in tissue_names(human)
    assert len(tissue_empty.vias_of(bpy.data.objects["Sartorius.R"])) == 1
    assert len(characters.vias_of(human)) == 2


def side_of(empty):
    return mirror.side_of(empty.name, empty.sinew.tissue.origin_bone, empty.sinew.tissue.insertion_bone)


def test_a_whole_side_is_mirrored_with_its_wrapping_spheres(human):
    before = tissue_names(human)
    edit.remove([empty for empty in characters.tissues_of(human) if side_of(empty) == "R"])
    bpy.context.view_layer.update()
    select(human)
    bpy.ops.sinew.mirror(direction="LEFT_TO_RIGHT")
    assert tissue_names(human) == before
    wraps = {
        tuple(mirror.flipped(wrap.sphere.name) for wrap in empty.sinew.tissue.wraps)
        for empty in characters.tissues_of(human)
    }
    assert wraps == {tuple(wrap.sphere.name for wrap in empty.sinew.tissue.wraps) for empty in characters.tissues_of(human)}
    assert not problems_of(human)


def test_a_muscle_without_the_twins_sphere_is_named_and_others_are_mirrored(human, capfd):
    edit.remove([bpy.data.objects["Shoulder joint.R"]])
    bpy.context.view_layer.update()
    select(bpy.data.objects["Biceps brachii, long head.L"], bpy.data.objects["Deltoid, acromial part.L"])
    bpy.ops.sinew.mirror()
    printed = capfd.readouterr().out
    assert "wraps around sphere 'Shoulder joint.R', which metarig does not have" in printed
    assert "1 tissues mirrored" in printed
