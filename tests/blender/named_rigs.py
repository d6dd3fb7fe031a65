# SPDX-License-Identifier: GPL-3.0-or-later
"""Rigs of a human with bone names of many conventions and languages, and with missing or further bones."""

import bpy
from conftest import select
from mathutils import Vector
from test_bone_recognition import LEFT, MIDDLE, PARENTS

PARTS = ("hips", "spine", "chest", "neck", "head")
LIMBS = ("clavicle", "upper_arm", "forearm", "hand", "thigh", "shin", "foot", "toes")
ROLES = {"hips": "pelvis", "neck": "neck", "head": "head", "clavicle": "shoulder_girdle"} | {
    limb: limb for limb in LIMBS if limb != "clavicle"
}
# The names of PARTS, of the LIMBS with {} for the side, and of the sides.
NAMES = {
    "French": (
        "bassin ventre poitrine cou tête",
        "clavicule_{} bras_{} avant-bras_{} main_{} cuisse_{} tibia_{} pied_{} orteils_{}",
        ("gauche", "droite"),
    ),
    "French, one letter": (
        "Hanches Colonne Thorax Cou Tete",
        "Epaule_{} Bras_{} AvantBras_{} Main_{} Cuisse_{} Jambe_{} Pied_{} Orteil_{}",
        ("G", "D"),
    ),
    "German": (
        "Becken Bauch Brustkorb Hals Kopf",
        "Schlüsselbein.{} Oberarm.{} Unterarm.{} Hand.{} Oberschenkel.{} Unterschenkel.{} Fuß.{} Zehen.{}",
        ("links", "rechts"),
    ),
    "Spanish": (
        "Cadera Columna Pecho Cuello Cabeza",
        "Clavicula{} Brazo{} Antebrazo{} Mano{} Muslo{} Pantorrilla{} Pie{} Dedos_Toe{}",
        ("Izquierda", "Derecha"),
    ),
    "Portuguese": (
        "quadril coluna peito pescoço cabeça",
        "clavícula_{} braço_{} antebraço_{} mão_{} coxa_{} canela_{} pé_{} artelho_{}",
        ("esq", "dir"),
    ),
    "Italian": (
        "bacino addome petto collo testa",
        "clavicola_{} braccio_{} avambraccio_{} mano_{} coscia_{} stinco_{} piede_{} alluce_{}",
        ("sx", "dx"),
    ),
    "Russian": (
        "таз живот грудь шея голова",
        "ключица_{} плечо_{} предплечье_{} кисть_{} бедро_{} голень_{} стопа_{} носок_{}",
        ("лев", "прав"),
    ),
    "Japanese": (
        "下半身 上半身 上半身2 首 頭",
        "{}肩 {}腕 {}ひじ {}手首 {}足 {}ひざ {}足首 {}つま先",
        ("左", "右"),
    ),
    "Japanese in Latin letters": (
        "koshi sebone mune kubi atama",
        "kata_{} ude_{} hiji_{} tekubi_{} momo_{} hiza_{} ashikubi_{} tsumasaki_{}",
        ("hidari", "migi"),
    ),
    "Chinese": (
        "骨盆 脊椎 胸部 颈部 头部",
        "{}锁骨 {}上臂 {}前臂 {}手 {}大腿 {}小腿 {}脚 {}脚趾",
        ("左", "右"),
    ),
    "Korean": (
        "골반 척추 가슴 목 머리",
        "{}쇄골 {}위팔 {}아래팔 {}손 {}허벅지 {}종아리 {}발 {}발가락",
        ("왼쪽", "오른쪽"),
    ),
    "3ds Max Biped": (
        "Bip01_Pelvis Bip01_Spine Bip01_Spine1 Bip01_Neck Bip01_Head",
        "Bip01_{}_Clavicle Bip01_{}_UpperArm Bip01_{}_Forearm Bip01_{}_Hand Bip01_{}_Thigh Bip01_{}_Calf Bip01_{}_Foot "
        "Bip01_{}_Toe0",
        ("L", "R"),
    ),
    "Daz": (
        "hip abdomenLower chestLower neckLower head",
        "{}Collar {}ShldrBend {}ForearmBend {}Hand {}ThighBend {}Shin {}Foot {}Toe",
        ("l", "r"),
    ),
    "Character Creator": (
        "CC_Base_Hip CC_Base_Waist CC_Base_Spine01 CC_Base_NeckTwist01 CC_Base_Head",
        "CC_Base_{}_Clavicle CC_Base_{}_Upperarm CC_Base_{}_Forearm CC_Base_{}_Hand CC_Base_{}_Thigh CC_Base_{}_Calf "
        "CC_Base_{}_Foot CC_Base_{}_ToeBase",
        ("L", "R"),
    ),
    "Advanced Skeleton": (
        "Root_M Spine1_M Chest_M Neck_M Head_M",
        "Scapula_{} Shoulder_{} Elbow_{} Wrist_{} Hip_{} Knee_{} Ankle_{} Toes_{}",
        ("L", "R"),
    ),
    "Auto-Rig Pro": (
        "root.x spine_01.x spine_02.x neck.x head.x",
        "shoulder.{} arm_stretch.{} forearm_stretch.{} hand.{} thigh_stretch.{} leg_stretch.{} foot.{} toes_01.{}",
        ("l", "r"),
    ),
    "Second Life": (
        "mPelvis mTorso mChest mNeck mHead",
        "mCollar{} mShoulder{} mElbow{} mWrist{} mHip{} mKnee{} mAnkle{} mToe{}",
        ("Left", "Right"),
    ),
    "SMPL": (
        "pelvis spine1 spine2 neck head",
        "{}_collar {}_shoulder {}_elbow {}_wrist {}_hip {}_knee {}_ankle {}_foot",
        ("left", "right"),
    ),
    "VRChat": (
        "Hips Spine Chest Neck Head",
        "{}+shoulder {}+arm {}+elbow {}+wrist {}+leg {}+knee {}+ankle {}+toe",
        ("Left", "Right"),
    ),
    "lower case": (
        "pelvis spine chest neck head",
        "{}clavicle {}upperarm {}forearm {}hand {}thigh {}calf {}foot {}toe",
        ("left", "right"),
    ),
}


def named(kind):
    """The bone name of each part for the left, the right and the middle of the body."""
    middle, limbs, sides = NAMES[kind]
    limbs = [limb.replace("+", " ") for limb in limbs.split()]
    return (
        dict(zip(PARTS, middle.split(), strict=True)),
        {
            side: dict(zip(LIMBS, (limb.format(mark) for limb in limbs), strict=True))
            for side, mark in zip("LR", sides, strict=True)
        },
    )


def built(middle, limbs, extra=()):
    """A rig of these bones. extra: (name, head, tail, name of the parent or "") of further bones."""
    data = bpy.data.armatures.new("Rig")
    rig = bpy.data.objects.new("Rig", data)
    bpy.context.scene.collection.objects.link(rig)
    select(rig)
    bpy.ops.object.mode_set(mode="EDIT")
    for side, sign, names in (("", 1, middle), *((side, {"L": 1, "R": -1}[side], names) for side, names in limbs.items())):
        for part, name in names.items():
            bone = data.edit_bones.new(name)
            bone.head = Vector((MIDDLE | LEFT)[part]) * Vector((sign, 1, 1))
            bone.tail = bone.head + Vector((0, 0, 0.15 if part == "head" else 0.04))
            parent = PARENTS.get(part)
            while parent and parent not in (names if side else middle) and parent not in middle:
                parent = PARENTS.get(parent)
            if parent:
                bone.parent = data.edit_bones[(names if parent in names else middle)[parent]]
    for name, head, tail, parent in extra:
        bone = data.edit_bones.new(name)
        bone.head, bone.tail = head, tail
        bone.parent = data.edit_bones[parent] if parent else None
    bpy.ops.object.mode_set(mode="OBJECT")
    select(rig)
    return rig


def without(kind, *parts):
    middle, limbs = named(kind)
    return (
        {part: name for part, name in middle.items() if part not in parts},
        {side: {part: name for part, name in names.items() if part not in parts} for side, names in limbs.items()},
    )


def cover(rig):
    """Gives a rig a mesh of points around each of its bones, up to where its first child starts."""
    points, bones = [], []
    for bone in rig.data.bones:
        end = (
            bone.children[0].head_local
            if bone.children
            else bone.head_local + 0.3 * (bone.head_local - bone.parent.head_local)
        )
        for along in (0.1, 0.5, 0.9):
            at = bone.head_local.lerp(end, along)
            points += [at + Vector(offset) for offset in ((0.02, 0, 0), (-0.02, 0, 0), (0, 0.02, 0), (0, -0.02, 0))]
            bones += [bone.name] * 4
    mesh = bpy.data.meshes.new("Cover")
    mesh.from_pydata(points, [], [])
    skin = bpy.data.objects.new("Cover", mesh)
    bpy.context.scene.collection.objects.link(skin)
    for bone in rig.data.bones:
        vertices = [index for index, name in enumerate(bones) if name == bone.name]
        skin.vertex_groups.new(name=bone.name).add(vertices, 1.0, "REPLACE")
    skin.parent = rig
    skin.modifiers.new("Armature", "ARMATURE").object = rig
    bpy.context.view_layer.update()
