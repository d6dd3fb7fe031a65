# SPDX-License-Identifier: GPL-3.0-or-later
"""Recognizing the bones of a body: rigs of common kinds, built in code, and unknown rigs."""

import bpy
import pytest
from bl_ext.user_default.sinew.errors import SinewError
from bl_ext.user_default.sinew.muscles.placing.place import placement, preset_file
from bl_ext.user_default.sinew.muscles.placing.recognise import recognition, segments, topology
from mathutils import Vector

# Joints of a person of 1.7 m in m, with arms out and -Y in front: the left half, and the middle.
MIDDLE = {
    "hips": (0, 0.01, 0.95),
    "spine": (0, 0.02, 1.06),
    "chest": (0, 0.04, 1.2),
    "upper_chest": (0, 0.04, 1.33),
    "neck": (0, 0.0, 1.48),
    "head": (0, -0.02, 1.57),
}
LEFT = {
    "clavicle": (0.03, -0.01, 1.42),
    "upper_arm": (0.18, 0.02, 1.4),
    "forearm": (0.44, 0.03, 1.4),
    "hand": (0.69, 0.0, 1.4),
    "index": (0.77, -0.03, 1.4),
    "middle": (0.78, -0.005, 1.4),
    "ring": (0.775, 0.02, 1.4),
    "little": (0.76, 0.04, 1.4),
    "thigh": (0.09, 0.0, 0.91),
    "shin": (0.1, -0.01, 0.5),
    "foot": (0.1, 0.03, 0.08),
    "toes": (0.11, -0.1, 0.02),
}
TWISTS = {"upper_arm_twist": 0.5, "forearm_twist": 0.6, "thigh_twist": 0.5, "shin_twist": 0.5}
PARENTS = {
    "spine": "hips", "chest": "spine", "upper_chest": "chest", "neck": "upper_chest", "head": "neck",
    "clavicle": "upper_chest", "upper_arm": "clavicle", "forearm": "upper_arm", "hand": "forearm", "index": "hand",
    "middle": "hand", "ring": "hand", "little": "hand", "thigh": "hips", "shin": "thigh", "foot": "shin", "toes": "foot",
    "upper_arm_twist": "upper_arm", "forearm_twist": "forearm", "thigh_twist": "thigh", "shin_twist": "shin",
}  # fmt: skip
MIXAMO = {
    "hips": "Hips", "spine": "Spine", "chest": "Spine1", "upper_chest": "Spine2", "neck": "Neck", "head": "Head",
    "clavicle": "{}Shoulder", "upper_arm": "{}Arm", "forearm": "{}ForeArm", "hand": "{}Hand", "index": "{}HandIndex1",
    "middle": "{}HandMiddle1", "ring": "{}HandRing1", "little": "{}HandPinky1", "thigh": "{}UpLeg", "shin": "{}Leg",
    "foot": "{}Foot", "toes": "{}ToeBase",
}  # fmt: skip
UNREAL = {
    "hips": "pelvis", "spine": "spine_01", "chest": "spine_02", "upper_chest": "spine_03", "neck": "neck_01",
    "head": "head", "clavicle": "clavicle_{}", "upper_arm": "upperarm_{}", "forearm": "lowerarm_{}", "hand": "hand_{}",
    "index": "index_01_{}", "middle": "middle_01_{}", "ring": "ring_01_{}", "little": "pinky_01_{}",
    "thigh": "thigh_{}", "shin": "calf_{}", "foot": "foot_{}", "toes": "ball_{}",
    "upper_arm_twist": "upperarm_twist_01_{}", "forearm_twist": "lowerarm_twist_01_{}",
    "thigh_twist": "thigh_twist_01_{}", "shin_twist": "calf_twist_01_{}",
}  # fmt: skip
VROID = {
    "hips": "J_Bip_C_Hips", "spine": "J_Bip_C_Spine", "chest": "J_Bip_C_Chest", "upper_chest": "J_Bip_C_UpperChest",
    "neck": "J_Bip_C_Neck", "head": "J_Bip_C_Head", "clavicle": "J_Bip_{}_Shoulder", "upper_arm": "J_Bip_{}_UpperArm",
    "forearm": "J_Bip_{}_LowerArm", "hand": "J_Bip_{}_Hand", "index": "J_Bip_{}_Index1", "middle": "J_Bip_{}_Middle1",
    "ring": "J_Bip_{}_Ring1", "little": "J_Bip_{}_Little1", "thigh": "J_Bip_{}_UpperLeg", "shin": "J_Bip_{}_LowerLeg",
    "foot": "J_Bip_{}_Foot", "toes": "J_Bip_{}_ToeBase",
}  # fmt: skip
VRM = {
    "hips": "hips", "spine": "spine", "chest": "chest", "upper_chest": "upperChest", "neck": "neck", "head": "head",
    "clavicle": "{}Shoulder", "upper_arm": "{}UpperArm", "forearm": "{}LowerArm", "hand": "{}Hand",
    "index": "{}IndexProximal", "middle": "{}MiddleProximal", "ring": "{}RingProximal", "little": "{}LittleProximal",
    "thigh": "{}UpperLeg", "shin": "{}LowerLeg", "foot": "{}Foot", "toes": "{}Toes",
}  # fmt: skip
NAMELESS = {part: f"Bone {number} {{}}" for number, part in enumerate((*MIDDLE, *LEFT))}
KINDS = {
    "Mixamo": (MIXAMO, ("Left", "Right"), "mixamorig:"),
    "Mixamo, bare": (MIXAMO, ("Left", "Right"), ""),
    "Unreal mannequin": (UNREAL, ("l", "r"), ""),
    "VRM (VRoid)": (VROID, ("L", "R"), ""),
    "VRM humanoid": (VRM, ("left", "right"), ""),
    "a rig recognised by its shape": (NAMELESS, ("x", "y"), ""),
}


def built(names, sides, prefix=""):
    """A rig whose tails have no meaning, as in imported files."""
    data = bpy.data.armatures.new("Rig")
    rig = bpy.data.objects.new("Rig", data)
    bpy.context.scene.collection.objects.link(rig)
    bpy.context.view_layer.objects.active = rig
    rig.select_set(True)
    bpy.ops.object.mode_set(mode="EDIT")
    joints = {part: Vector(at) for part, at in (MIDDLE | LEFT).items()}
    for twist, share in TWISTS.items():
        upper = twist.removesuffix("_twist")
        lower = next(part for part, parent in PARENTS.items() if parent == upper and part in LEFT)
        joints[twist] = joints[upper].lerp(joints[lower], share)
    for part in (*MIDDLE, *LEFT, *TWISTS):
        if part not in names:
            continue
        for side, sign in ((sides[0], 1), (sides[1], -1)) if part not in MIDDLE else (("", 1),):
            bone = data.edit_bones.new(prefix + names[part].format(side))
            at = joints[part]
            bone.head = (at.x * sign, at.y, at.z)
            bone.tail = bone.head + Vector((0, 0, 0.15 if part == "head" else 0.04))
            parent = PARENTS.get(part)
            if parent:
                bone.parent = data.edit_bones[prefix + names[parent].format("" if parent in MIDDLE else side)]
    bpy.ops.object.mode_set(mode="OBJECT")
    return rig


@pytest.mark.parametrize("kind", KINDS)
def test_a_rig_with_known_names_is_recognized(kind):
    names, sides, prefix = KINDS[kind]
    rig = built(names, sides, prefix)
    body = segments.recognise(rig)
    assert body.scheme == kind.removesuffix(", bare")
    for part in ("upper_arm", "forearm", "hand", "thigh", "shin", "foot"):
        for side, own in zip("LR", sides, strict=True):
            assert body.segment(part, side).bones[0] == prefix + names[part].format(own), part
    assert body.segment("pelvis", "L").bones[0] == prefix + names["hips"].format("")
    assert body.segment("head", "L").bones == (prefix + names["head"].format(""),)
    shapes = placement.place(preset_file.read("human"), body, None)
    assert sum(shape.kind == "MUSCLE" for shape in shapes) == 252
    assert body.segment("forearm", "L").end.x == pytest.approx(0.69, abs=1e-5)


def test_twist_bones_belong_to_their_segment():
    body = segments.recognise(built(UNREAL, ("l", "r")))
    forearm = body.segment("forearm", "L")
    assert forearm.bones == ("lowerarm_l", "lowerarm_twist_01_l")
    assert forearm.bone_at(0.3) == "lowerarm_l"
    assert forearm.bone_at(0.9) == "lowerarm_twist_01_l"


def test_a_generated_rig_uses_its_deform_bones(rigify):
    bpy.ops.object.armature_human_metarig_add()
    bpy.ops.pose.rigify_generate()
    rig = next(found for found in bpy.data.objects if found.type == "ARMATURE" and "metarig" not in found.name)
    body = segments.recognise(rig)
    assert body.scheme == "Rigify human, generated"
    assert body.segment("forearm", "L").bones == ("DEF-forearm.L", "DEF-forearm.L.001")
    shapes = placement.place(preset_file.read("human"), body, None)
    assert sum(shape.kind == "MUSCLE" for shape in shapes) == 252
    assert all(rig.data.bones[shape.origin_bone].use_deform for shape in shapes)


def test_the_cat_has_27_segments(rigify):
    bpy.ops.object.armature_cat_metarig_add()
    body = segments.recognise(bpy.context.object)
    assert body.scheme == "Rigify cat"
    assert len(body.segments) == 27
    assert body.segment("chest", "L").front.z < -0.9
    assert body.segment("thigh", "L").front.y < -0.9


@pytest.mark.parametrize("metarig", ["human", "cat"])
def test_shape_alone_finds_the_same_bones_as_names(rigify, metarig):
    getattr(bpy.ops.object, f"armature_{metarig}_metarig_add")()
    rig = bpy.context.object
    by_names, by_shape = recognition.recognise(rig).chains, topology.chains_of(rig)
    optional = ("fingers", "toes", "jaw")
    for place, bones in by_names.items():
        if place[0] not in optional:
            assert by_shape[place][0] == bones[0] or place[0] in ("abdomen", "chest"), place


def test_a_wolf_is_recognized_by_shape_and_takes_the_cat_preset(rigify):
    bpy.ops.object.armature_wolf_metarig_add()
    rig = bpy.context.object
    assert segments.recognise(rig).scheme == "Rigify wolf"
    left_arm = segments.recognise(rig).segment("upper_arm", "L").bones[0]
    names = {bone.name: f"x{number}" for number, bone in enumerate(rig.data.bones)}
    for name, strange in names.items():
        rig.data.bones[name].name = strange
    body = segments.recognise(rig)
    assert body.scheme == "a rig recognised by its shape"
    assert body.segment("upper_arm", "L").bones == (names[left_arm],)
    shapes = placement.place(preset_file.read("cat"), body, None)
    assert sum(shape.kind == "MUSCLE" for shape in shapes) > 100


def test_shape_alone_finds_split_limbs(real_body):
    _, rig = real_body
    chains = topology.chains_of(rig)
    assert chains["thigh", "L"] == ("upperleg01.L", "upperleg02.L")
    assert chains["upper_arm", "R"] == ("upperarm01.R", "upperarm02.R")
    assert chains["forearm", "R"] == ("lowerarm01.R", "lowerarm02.R")
    assert chains["head", ""] == ("head",)


def test_a_correction_includes_bones_down_to_the_next_segment():
    rig = built(UNREAL, ("l", "r"))
    rig.data.bones["lowerarm_l"].name = "strange"
    assert not segments.recognise(rig).has("forearm", "L")
    body = segments.recognise(rig, {("forearm", "L"): "strange"})
    assert body.segment("forearm", "L").bones == ("strange",)
    assert body.segment("forearm", "L").end.x == pytest.approx(0.69, abs=1e-5)


@pytest.mark.parametrize(
    ("correction", "message"),
    [
        ({("forearm", "L"): "gone"}, "forearm L is set to 'gone', but 'Rig' has no such bone"),
        ({("wing", "L"): "hips"}, "there is no segment 'wing L'"),
        ({("forearm", ""): "hips"}, "there is no segment 'forearm'"),
    ],
)
def test_a_wrong_correction_is_reported(correction, message):
    with pytest.raises(SinewError, match=message):
        segments.recognise(built(VRM, ("left", "right")), correction)
