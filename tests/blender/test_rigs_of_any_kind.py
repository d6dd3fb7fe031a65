# SPDX-License-Identifier: GPL-3.0-or-later
"""Presets on rigs with names of many conventions and languages, with missing parts and control bones, and on random rigs."""

import json
import math
import random

import bpy
import pytest
from bl_ext.user_default.sinew.errors import SinewError
from bl_ext.user_default.sinew.muscles.placing.place import placement, preset_file
from bl_ext.user_default.sinew.muscles.placing.recognise import creature, kind, recognition, segments
from bl_ext.user_default.sinew.reach import chains as reach_chains
from mathutils import Matrix, Vector
from named_rigs import LIMBS, NAMES, PARTS, ROLES, built, cover, named, without

pytestmark = pytest.mark.one_blender

MUSCLES = 252
WORDS = (
    "hips", "pelvis", "spine", "chest", "neck", "head", "shoulder", "clavicle", "arm", "upperarm", "forearm",
    "hand", "thumb", "index", "thigh", "leg", "shin", "knee", "foot", "toe", "tail", "wing", "fin", "jaw", "ik",
    "ctrl", "twist", "bone", "joint", "bras", "jambe", "Oberarm", "腕", "足", "左", "右", "front", "back", "end", "L",
    "R", "_l", ".R", "01", "2",
)  # fmt: skip


def muscles():
    return {found.name for found in bpy.data.objects if found.sinew.tissue.kind == "MUSCLE"}


def warning(rig, preset):
    found = kind.kind_of_character(rig)
    return creature.warning(rig, segments.recognise(rig), preset, preset_file.read(preset).creature, found)


def assert_recognized(rig, middle, limbs):
    found = recognition.recognise(rig).chains
    for side, names in (("", middle), *limbs.items()):
        for part, name in names.items():
            if part in ROLES:
                assert found[ROLES[part], side][0] == name, part


# Names


@pytest.mark.parametrize("kind", NAMES)
def test_names_in_many_languages_and_conventions(kind):
    middle, limbs = named(kind)
    rig = built(middle, limbs)
    assert_recognized(rig, middle, limbs)
    bpy.ops.sinew.add_preset(name="human")
    assert len(muscles()) == MUSCLES
    assert warning(rig, "human") == ""


@pytest.mark.parametrize("kind", ["German", "3ds Max Biped", "Daz", "Japanese"])
def test_control_twist_and_one_sided_bones_are_passed_over(kind):
    middle, limbs = named(kind)
    extra = [("IKlegPole.L", (0.1, -1, 0.5), (0.1, -2, 0.5), ""), ("hand_ik.L", (0.69, 0, 1.4), (0.9, 0, 1.4), "")]
    extra += [("IKlegPole.R", (-0.1, -1, 0.5), (-0.1, -2, 0.5), ""), ("hand_ik.R", (-0.69, 0, 1.4), (-0.9, 0, 1.4), "")]
    extra += [
        ("Sword", (0.7, 0, 1.4), (0.7, -2, 1.4), limbs["L"]["hand"]),
        ("Heel.L", (0.1, 0, 0), (0.1, 0.1, 0), limbs["L"]["foot"]),
    ]
    extra += [("Thigh_Twist.L", (0.1, 0, 0.7), (0.1, 0, 0.6), limbs["L"]["thigh"])]
    rig = built(middle, limbs, extra)
    assert_recognized(rig, middle, limbs)
    bpy.ops.sinew.add_preset(name="human")
    assert len(muscles()) == MUSCLES


def test_a_one_sided_bone_does_not_break_a_pair_without_names():
    middle, limbs = named("German")
    numbered = {side: {part: f"Bone.{side}{i}" for i, part in enumerate(names)} for side, names in limbs.items()}
    numbered = {
        side: {p: n.replace(".L", "x").replace(".R", "y") for p, n in names.items()} for side, names in numbered.items()
    }
    middle = {part: f"Mid{i}" for i, part in enumerate(middle)}
    extra = [("Spike", (0.11, -0.1, 0.02), (0.11, -1.5, 0.02), numbered["L"]["toes"])]
    rig = built(middle, numbered, extra)
    assert recognition.recognise(rig).chains["shin", "L"] == (numbered["L"]["shin"],)
    bpy.ops.sinew.add_preset(name="human")
    assert len(muscles()) == MUSCLES


def test_feet_under_control_bones_belong_to_the_legs():
    middle, limbs = without("3ds Max Biped", "foot", "toes")
    extra = []
    for side, x in (("L", 0.1), ("R", -0.1)):
        extra += [
            (f"IK_{side}", (x, 0.03, 0.08), (x, 0.3, 0.08), ""),
            (f"{side}_Foot", (x, 0.03, 0.08), (x, -0.1, 0.02), f"IK_{side}"),
        ]
    rig = built(middle, limbs, extra)
    assert recognition.recognise(rig).chains["foot", "R"] == ("R_Foot",)


# Missing parts


@pytest.mark.parametrize("kind", ["French", "Daz", "SMPL"])
@pytest.mark.parametrize(
    "parts",
    [("neck",), ("head",), ("neck", "head"), ("clavicle",), ("toes",), ("chest",), ("foot", "toes"), ("hand",), ("hips",)],
)
def test_muscles_on_missing_parts_are_left_out(kind, parts):
    middle, limbs = without(kind, *parts)
    rig = built(middle, limbs)
    bpy.ops.sinew.add_preset(name="human")
    body, preset = segments.recognise(rig), preset_file.read("human")
    left_out = {name for names in placement.left_out(preset, body).values() for name in names}
    assert not muscles() & left_out
    assert len(muscles()) > 60
    for part in parts:
        assert part in ("chest", "hips") or not body.has(ROLES[part], "L")
    carriers = {found.parent_bone for found in bpy.data.objects if found.sinew.tissue.kind == "MUSCLE"}
    assert carriers <= set(rig.data.bones.keys())


def test_the_report_names_the_missing_parts_and_counts_what_is_left_out(capfd):
    built(*without("French", "neck", "clavicle"))
    bpy.ops.sinew.add_preset(name="human")
    printed = capfd.readouterr().out
    assert "tissues left out (no shoulder girdle, no neck, no fingers)" in printed
    assert "Rig has no neck: " in printed


def test_a_known_kind_of_rig_without_a_neck(capfd):
    middle, limbs = without("VRChat", "neck")
    built(
        middle,
        {
            side: {part: f"{word}{part.title().replace('_', '')}" for part in names}
            for (side, names), word in zip(limbs.items(), ("left", "right"), strict=True)
        },
    )
    bpy.ops.sinew.add_preset(name="human")
    assert 100 < len(muscles()) < MUSCLES
    assert "no neck" in capfd.readouterr().out


def test_muscles_of_one_side_are_left_out():
    middle, limbs = named("German")
    limbs["L"] = {part: name for part, name in limbs["L"].items() if part not in ("forearm", "hand")}
    rig = built(middle, limbs)
    bpy.ops.sinew.add_preset(name="limbs")
    assert "Brachialis.R" in muscles() and "Brachialis.L" not in muscles()
    assert "forearm L" in placement.left_out(preset_file.read("limbs"), segments.recognise(rig))


def test_a_hand_as_long_as_the_arm_is_a_forearm():
    middle, limbs = without("French", "clavicle", "forearm", "hand", "neck")
    extra = [
        (f"main {word}", (x, 0, 1.4), (2.2 * x, 0, 1.4), limbs[side]["upper_arm"])
        for side, word, x in (("L", "gauche", 0.44), ("R", "droite", -0.44))
    ]
    rig = built(middle, limbs, extra)
    assert recognition.recognise(rig).chains["forearm", "L"] == ("main gauche",)


# Other creatures


def quadruped():
    middle = (
        ("Hips", (0, 0.5, 1)),
        ("Spine", (0, 0.2, 1)),
        ("Chest", (0, -0.3, 1)),
        ("Neck", (0, -0.5, 1.1)),
        ("Head", (0, -0.7, 1.4)),
    )
    extra = [
        (name, at, Vector(at) + Vector((0, -0.1, 0)), middle[i - 1][0] if i else "") for i, (name, at) in enumerate(middle)
    ]
    for side, x in (("L", 0.2), ("R", -0.2)):
        for end, y, parent in (("Front", -0.3, "Chest"), ("Back", 0.5, "Hips")):
            joints = [Vector((x, y, 0.9)), Vector((x, y + 0.05, 0.5)), Vector((x, y, 0.1)), Vector((x, y - 0.1, 0.0))]
            for i, what in enumerate(("Upper", "Lower", "Foot")):
                name = f"{end}_Leg_{what}_{side}"
                extra.append((name, joints[i], joints[i + 1], parent))
                parent = name
    return built({}, {}, extra)


def test_a_preset_for_humans_warns_on_four_legs(capfd):
    rig = quadruped()
    bpy.ops.sinew.add_preset(name="human")
    assert "Warning: Rig doesn't look like a human: it stands on four legs" in capfd.readouterr().out
    assert warning(rig, "cat") == ""
    assert reach_chains.ends_of(rig)


def test_an_armature_without_bones_is_refused_in_words():
    rig = built({}, {})
    for preset in ("human", "limbs", "cat"):
        with pytest.raises(RuntimeError, match="isn't a rig that Sinew knows"):
            bpy.ops.sinew.add_preset(name=preset)
    assert reach_chains.ends_of(rig) == {}


def test_a_long_chain_of_bones_is_no_recursion():
    middle, limbs = named("German")
    numbered = {side: {part: f"B{side}{i}x" for i, part in enumerate(names)} for side, names in limbs.items()}
    middle = {part: f"M{i}x" for i, part in enumerate(middle)}
    extra, parent = [], middle["chest"]
    for i in range(1500):
        extra.append((f"T{i}", (0, 0.001 * i, 1.2), (0, 0.001 * i + 0.001, 1.2), parent))
        parent = f"T{i}"
    rig = built(middle, numbered, extra)
    assert ("thigh", "L") in recognition.recognise(rig).chains


@pytest.mark.parametrize("seed", range(60))
def test_random_rigs_take_a_preset_or_refuse_it_in_words(seed):
    chance = random.Random(seed)
    words = WORDS if seed % 3 else ("x",)
    extra = []
    for index in range(chance.choice((1, 2, 3, 5, 8, 15, 30, 50))):
        name = f"{chance.choice(('_', ' ', '')).join(chance.sample(words, min(len(words), chance.randint(1, 3))))}.{index}"
        parent = chance.choice(extra)[0] if extra and chance.random() < 0.9 else ""
        head = Vector(chance.choice((chance.uniform(-1, 1), 0.0)) for _ in range(3))
        if parent and chance.random() < 0.6:
            head = next(Vector(tail) for bone, _, tail, _ in extra if bone == parent)
        tail = head + Vector(chance.choice((chance.uniform(-0.5, 0.5), 0.0)) for _ in range(3)) + Vector((0, 0, 1e-4))
        extra.append((name, head, tail, parent))
        if chance.random() < 0.6:
            flip = Vector((-1, 1, 1))
            extra.append((f"{name}.R", head * flip, tail * flip, parent))
    rig = built({}, {}, extra)
    for preset in ("human", "limbs", "cat"):
        try:
            bpy.ops.sinew.add_preset(name=preset)
        except RuntimeError as refusal:
            assert "Traceback" not in str(refusal)
            assert len(str(refusal)) > 40
    ends = reach_chains.ends_of(rig)
    assert all(bone in rig.data.bones for bone in ends.values())
    for bone in list(rig.data.bones.keys())[:5]:
        assert reach_chains.chain_of(rig, bone)


@pytest.mark.parametrize("seed", range(40))
def test_humans_with_random_parts_missing_take_a_preset_or_refuse_it_in_words(seed):
    chance = random.Random(1000 + seed)
    middle, limbs = named(chance.choice(list(NAMES)))
    lost = set(chance.sample((*PARTS, *LIMBS), chance.randint(1, 6)))
    middle = {part: name for part, name in middle.items() if part not in lost}
    limbs = {
        side: {p: n for p, n in names.items() if p not in lost and chance.random() > 0.05} for side, names in limbs.items()
    }
    rig = built(middle, limbs)
    try:
        bpy.ops.sinew.add_preset(name="human")
        assert muscles()
    except RuntimeError as refusal:
        assert "Traceback" not in str(refusal)
        with pytest.raises(SinewError):
            placement.require(preset_file.read("human"), segments.recognise(rig))


@pytest.mark.parametrize("parts", [("thigh", "shin", "foot", "toes"), ("clavicle", "upper_arm", "forearm", "hand")])
def test_half_a_body(parts):
    middle, limbs = without("German", *parts)
    rig = built(middle, limbs)
    bpy.ops.sinew.add_preset(name="human")
    body = segments.recognise(rig)
    assert len(muscles()) > 40
    assert body.segment("chest", "L").front.y < -0.9
    assert body.segment("chest", "L").outer.x > 0.9


def test_a_body_with_one_leg():
    middle, limbs = named("French")
    limbs["R"] = {part: name for part, name in limbs["R"].items() if part not in ("thigh", "shin", "foot", "toes")}
    built(middle, limbs)
    bpy.ops.sinew.add_preset(name="human")
    assert "Rectus femoris.L" in muscles() and "Rectus femoris.R" not in muscles()


def test_a_word_in_every_name_says_nothing():
    middle, limbs = named("3ds Max Biped")
    middle = {part: f"ctrl_{name}" for part, name in middle.items()}
    limbs = {side: {part: f"ctrl_{name}" for part, name in names.items()} for side, names in limbs.items()}
    assert_recognized(built(middle, limbs), middle, limbs)


def test_a_pelvis_without_length_is_left_out():
    middle, limbs = named("German")
    rig = built(middle, limbs)
    bpy.ops.object.mode_set(mode="EDIT")
    hips = sum((rig.data.edit_bones[limbs[side]["thigh"]].head for side in "LR"), Vector()) / 2
    for part in PARTS:  # all at the hips, so that the trunk has no length
        rig.data.edit_bones[middle[part]].head = hips
        rig.data.edit_bones[middle[part]].tail = hips + Vector((0, 0, 0.1))
    bpy.ops.object.mode_set(mode="OBJECT")
    bpy.ops.sinew.add_preset(name="human")
    assert "Soleus.L" in muscles()


def test_a_muscle_without_length_does_not_refuse_the_preset(tmp_path):
    preset = json.loads((preset_file.FOLDER / "limbs.json").read_text(encoding="utf-8"))
    point = {"segment": "thigh", "along": 0.5, "around": 0, "depth": 0.5}
    muscle = next(entry for entry in preset["tissues"] if "origin" in entry and not entry.get("belly"))
    muscle |= {"origin": point, "insertion": point}
    path = tmp_path / "short.json"
    path.write_text(json.dumps(preset), encoding="utf-8")
    rig = built(*named("German"))
    body, short = segments.recognise(rig), preset_file.read(str(path))
    shapes = placement.place(short, body, None)
    left_out = placement.not_placed(short, body, shapes)
    assert left_out and all(name.startswith(muscle["name"]) for name in left_out)
    assert len(shapes) == len(placement.place(preset_file.read("limbs"), body, None)) - len(left_out)


# What imported files bring


def without_names(kind):
    middle, limbs = named(kind)
    numbers = iter(range(100))
    middle = {part: f"Bone_{next(numbers):03}" for part in middle}
    return middle, {side: {part: f"Bone_{next(numbers):03}" for part in names} for side, names in limbs.items()}


def hang_arms(rig, limbs, degrees):
    """Turns the bones of both arms down about the shoulders."""
    bpy.ops.object.mode_set(mode="EDIT")
    for side, names in limbs.items():
        pivot = rig.data.edit_bones[names["upper_arm"]].head.copy()
        turn = Matrix.Rotation(math.radians(degrees if side == "L" else -degrees), 3, "Y")
        for part in ("forearm", "hand"):
            bone = rig.data.edit_bones[names[part]]
            bone.head = pivot + turn @ (bone.head - pivot)
    bpy.ops.object.mode_set(mode="OBJECT")


def scatter_tails(rig, seed):
    """Points all bones in random directions, as some imports do."""
    chance = random.Random(seed)
    bpy.ops.object.mode_set(mode="EDIT")
    for bone in rig.data.edit_bones:
        direction = Vector([chance.uniform(-1, 1) for _ in range(3)]).normalized()
        bone.tail = bone.head + direction * chance.uniform(0.02, 0.3)
    bpy.ops.object.mode_set(mode="OBJECT")


@pytest.mark.parametrize("degrees", [0, 45, 80])
def test_bones_without_names_that_point_anywhere(degrees):
    middle, limbs = without_names("German")
    rig = built(middle, limbs)
    hang_arms(rig, limbs, degrees)
    scatter_tails(rig, degrees)
    cover(rig)
    found = recognition.recognise(rig).chains
    for part in ("upper_arm", "forearm", "hand", "thigh", "shin", "foot"):
        for side in "LR":
            assert found[part, side][0] in (limbs["L"][part], limbs["R"][part])
    assert kind.kind_of_character(rig).name == "human"


@pytest.mark.parametrize("prefix", ["", "Character1_", "ORG-", "char|"])
def test_a_spine_counted_through_the_neck_to_the_head(prefix):
    middle = dict(zip(("hips", "spine", "chest", "neck", "head"), ("", ".001", ".002", ".004", ".006"), strict=True))
    middle = {part: f"{prefix}spine{number}" for part, number in middle.items()}
    _, limbs = named("Auto-Rig Pro")
    limbs = {side: {part: f"{prefix}{name}" for part, name in names.items()} for side, names in limbs.items()}
    assert_recognized(built(middle, limbs), middle, limbs)


def test_a_spine_with_one_more_bone_below_the_arms():
    """MPFB's Rigify rig: the arms hang from spine.004, which is the neck in Rigify's own."""
    middle = {"hips": "spine", "spine": "spine.001", "chest": "spine.004", "neck": "spine.005", "head": "spine.006"}
    names = ["shoulder.{}", "upper_arm.{}", "forearm.{}", "hand.{}", "thigh.{}", "shin.{}", "foot.{}", "toe.{}"]
    limbs = {side: dict(zip(LIMBS, (name.format(side) for name in names), strict=True)) for side in "LR"}
    between = [
        ("spine.002", (0, 0.03, 1.1), (0, 0.03, 1.14), "spine.001"),
        ("spine.003", (0, 0.03, 1.15), (0, 0, 1.19), "spine.002"),
    ]
    rig = built(middle, limbs, between)
    bpy.ops.object.mode_set(mode="EDIT")
    rig.data.edit_bones["spine.004"].parent = rig.data.edit_bones["spine.003"]
    bpy.ops.object.mode_set(mode="OBJECT")
    found = recognition.recognise(rig)
    assert found.label == "Rigify human"
    assert found.chains["neck", ""] == ("spine.005",) and found.chains["chest", ""][-1] == "spine.004"


def test_a_skirt_with_more_bones_than_the_body():
    middle, limbs = named("Character Creator")
    extra = []
    for strand in range(12):
        across, along = 0.15 * math.cos(strand * math.pi / 6 + 0.2), 0.15 * math.sin(strand * math.pi / 6 + 0.2)
        parent = middle["hips"]
        for link in range(5):
            height = 0.9 - 0.17 * link
            name = f"Skirt_{strand}_{link}"
            extra.append((name, (across, along, height), (across, along, height - 0.17), parent))
            parent = name
    rig = built(middle, limbs, extra)
    assert_recognized(rig, middle, limbs)
    assert kind.kind_of_character(rig).name == "human"


def test_all_limbs_on_one_bone_that_is_named_as_a_root():
    middle, limbs = without("Advanced Skeleton", "spine", "chest", "neck", "head")
    rig = built(middle, limbs)
    assert recognition.recognise(rig).chains["pelvis", ""] == ("Root_M",)


@pytest.mark.parametrize("axis", "XY")
def test_a_human_that_lies_is_a_human(axis):
    rig = built(*named("Daz"))
    rig.matrix_world = Matrix.Rotation(math.radians(90), 4, axis)
    bpy.context.view_layer.update()
    assert kind.kind_of_character(rig).name == "human"
