# SPDX-License-Identifier: GPL-3.0-or-later
"""The kind of creature that a rig is, and the muscles that Add Muscles chooses for it."""

import math
import random

import bpy
import pytest
from bl_ext.user_default.sinew.muscles.placing.place import preset_file
from bl_ext.user_default.sinew.muscles.placing.recognise import choice, kind, segments
from bl_ext.user_default.sinew.operators import add_muscles
from bl_ext.user_default.sinew.scene import characters
from conftest import select
from creature_rigs import bird, built, chain, fish, many_legs, on_fours, pair, row
from mathutils import Matrix, Vector
from test_rigs_of_any_kind import NAMES, WORDS, named
from test_rigs_of_any_kind import built as human_of

pytestmark = pytest.mark.one_blender

LR = ("L", "R")
NUMBERS = [f"Bone.{i:03d}" for i in range(60)]


def numbered(bones):
    """The same bones with names that say nothing."""
    names = {bone: NUMBERS[i] for i, (bone, *_rest) in enumerate(bones)}
    return [(names[bone], head, tail, names.get(parent, "")) for bone, head, tail, parent in bones]


def by_eye(bones):
    """The same bones with those of the right side a little off their mirror image, as a rigger places them by eye."""
    off = [(0.012, -0.02, 0.01), (-0.01, 0.012, 0.018)]

    def moved(point, index):
        return tuple(a + b for a, b in zip(point, off[index % 2], strict=True)) if point[0] < -0.02 else point

    return [(name, moved(head, i), moved(tail, i + 1), parent) for i, (name, head, tail, parent) in enumerate(bones)]


SPINE = ["Pelvis", "Spine1", "Chest", "Neck", "Head"]
# A frog as it sits. Its feet do not hang from its legs, so a foot is not taken for a hip.
FROG = (
    chain(["Hips", "Torso", "Neck", "Head"], ((0, 0.7, 0.7), (0, 0.2, 0.8), (0, -0.7, 1.1), (0, -1, 1.15), (0, -1.5, 1.2)))
    + pair((LR, ["FrontLeg_{}", "FrontUpLeg_{}", "FrontLowLeg_{}"]),
           ((0.45, -0.55, 1.0), (0.67, -0.55, 1.0), (1.07, -0.06, 0.36), (1.07, -0.8, 0)), "Torso")
    + pair((LR, ["BackLeg_{}", "BackUpLeg_{}", "BackLowLeg_{}"]),
           ((0.5, 1.0, 0.5), (1.05, 0.3, 0.3), (0.9, 1.4, 0.06), (1.3, 0.45, 0)), "Hips")
    + pair((LR, ["FrontFoot_{}"]), ((1.07, -0.85, 0), (1.07, -1.2, 0)), "")
    + pair((LR, ["BackFoot_{}"]), ((1.33, 0.42, 0), (1.33, 0.1, 0)), "")
)  # fmt: skip
DOG = on_fours(
    SPINE,
    (LR, ["Scapula_{}", "Humerus_{}", "Radius_{}", "FrontPaw_{}"]),
    (LR, ["Femur_{}", "Tibia_{}", "Hock_{}", "HindPaw_{}"]),
    ["Tail1", "Tail2", "Tail3"],
)
SPIDER = many_legs(["abdomen", "thorax", "head"], (("l", "r"), ["leg_#_1_{}", "leg_#_2_{}", "leg_#_3_{}"]), 4)
BIRD = bird(SPINE, (LR, ["Wing1_{}", "Wing2_{}", "Wing3_{}"]), (LR, ["Thigh_{}", "Shin_{}", "Foot_{}", "Toe_{}"]))
# A root under the body, from which the spine and the face hang, and a spine of four bones.
LEVEL_FISH = [
    ("root", (0, 0, -0.3), (0, 0, -0.2), ""),
    ("face", (0, -0.6, 0), (0, -0.8, 0), "root"),
    *chain(["spine1", "spine2", "spine3", "tail"], [(0, y, 0) for y in (-0.5, 0, 0.5, 1.0, 1.4)], "root"),
]
CREATURES = {
    "dog": ("quadruped", DOG),
    "dog without names": ("quadruped", numbered(DOG)),
    "dog placed by eye": ("quadruped", numbered(by_eye(DOG))),
    "frog with feet apart": ("quadruped", FROG),
    "long animal with short legs": (
        "other",
        chain(["Tail", "Pelvis", "Torso", "Neck", "Head"], [(0, y, 0) for y in (2, 1, 0, -1, -2, -2.5)])
        + pair((LR, ["BackLegUpper_{}", "BackLegLower_{}"]), [(0.1, 0.9, -0.1 * i) for i in range(3)], "Pelvis"),
    ),
    "horse, front and back": (
        "quadruped",
        on_fours(
            ["Hips", "Spine", "Torso", "Neck", "Head"],
            ((".L", ".R"), ["FrontShoulder{}", "FrontUpperLeg{}", "FrontLowerLeg{}", "FrontFoot{}"]),
            ((".L", ".R"), ["BackUpperLeg{}", "BackLowerLeg{}", "BackFoot{}", "BackToe{}"]),
            size="horse",
        ),
    ),
    "horse with the names of Biped": (
        "quadruped",
        on_fours(
            ["Bip01 Pelvis", "Bip01 Spine", "Bip01 Spine1", "Bip01 Neck", "Bip01 Head"],
            (LR, ["Bip01 {} Clavicle", "Bip01 {} UpperArm", "Bip01 {} Forearm", "Bip01 {} Hand"]),
            (LR, ["Bip01 {} Thigh", "Bip01 {} Calf", "Bip01 {} HorseLink", "Bip01 {} Foot"]),
            size="horse",
        ),
    ),
    "cat with the names of Rigify": (
        "quadruped",
        on_fours(
            ["spine", "spine.001", "spine.003", "spine.005", "spine.006"],
            (LR, ["shoulder.{}", "upper_arm.{}", "forearm.{}", "hand.{}"]),
            (LR, ["thigh.{}", "shin.{}", "foot.{}", "r_toe.{}"]),
        ),
    ),
    "German dog": (
        "quadruped",
        on_fours(
            ["Becken", "Wirbelsäule", "Brust", "Hals", "Kopf"],
            ((".L", ".R"), ["Schulterblatt{}", "Vorderbein_oben{}", "Vorderbein_unten{}", "Vorderpfote{}"]),
            ((".L", ".R"), ["Oberschenkel{}", "Unterschenkel{}", "Hinterfuß{}", "Zehen{}"]),
            ["Schwanz1", "Schwanz2", "Schwanz3"],
        ),
    ),
    "French dog": (
        "quadruped",
        on_fours(
            ["bassin", "colonne", "poitrine", "cou", "tête"],
            (("gauche", "droite"), ["épaule_{}", "bras_{}", "avant-bras_{}", "patte_avant_{}"]),
            (("gauche", "droite"), ["cuisse_{}", "tibia_{}", "cheville_{}", "patte_arrière_{}"]),
        ),
    ),
    "Japanese dog": (
        "quadruped",
        on_fours(
            ["腰", "背骨", "胸", "首", "頭"],
            (("左", "右"), ["{}肩", "{}上腕", "{}前腕", "{}前足"]),
            (("左", "右"), ["{}太もも", "{}すね", "{}足首", "{}後足"]),
        ),
    ),
    "Spanish horse": (
        "quadruped",
        on_fours(
            ["cadera", "columna", "pecho", "cuello", "cabeza"],
            (("izq", "der"), ["escapula_{}", "pata_delantera_1_{}", "pata_delantera_2_{}", "pezuña_delantera_{}"]),
            (("izq", "der"), ["muslo_{}", "pantorrilla_{}", "tobillo_{}", "pezuña_trasera_{}"]),
            size="horse",
        ),
    ),
    "bird": ("bird", BIRD),
    "bird without names": ("bird", numbered(BIRD)),
    "bird with the names of arms": (
        "bird",
        bird(
            [*SPINE[:4], "Beak"],
            (LR, ["upper_arm.{}", "forearm.{}", "hand.{}"]),
            (LR, ["thigh.{}", "tibiotarsus.{}", "tarsometatarsus.{}", "toe.{}"]),
        ),
    ),
    "Russian bird": (
        "bird",
        bird(
            ["таз", "позвоночник", "грудь", "шея", "голова"],
            (("лев", "прав"), ["крыло1_{}", "крыло2_{}", "крыло3_{}"]),
            (("лев", "прав"), ["бедро_{}", "голень_{}", "стопа_{}", "носок_{}"]),
        ),
    ),
    "fish": ("fish", fish(["Head", "Body1", "Body2", "Body3", "Tail1"], (LR, ["Fin_{}", "FinTip_{}"]), ["DorsalFin"])),
    "fish from the tail": (
        "fish",
        fish(["spine.00", "spine.01", "spine.02", "head"], (LR, ["fin.{}", "fin.001.{}"]), headfirst=False),
    ),
    "Japanese fish": ("fish", fish(["頭", "体1", "体2", "尾"], (("左", "右"), ["{}ひれ", "{}ひれ先"]), ["背びれ"])),
    "fish placed by eye": ("fish", by_eye(fish(["Head", "Body1", "Body2", "Tail1"], (LR, ["Fin_{}", "FinTip_{}"])))),
    "spider": ("arthropod", SPIDER),
    "spider without names": ("arthropod", numbered(SPIDER)),
    "ant": (
        "arthropod",
        many_legs(["abdomen", "thorax", "head"], (LR, ["Coxa#_{}", "Femur#_{}", "Tibia#_{}"]), 3)
        + pair((LR, ["antenna_{}", "antenna_tip_{}"]), ((0.03, -0.4, 0.35), (0.1, -0.5, 0.5), (0.15, -0.7, 0.5)), "head"),
    ),
    "snake": ("other", row(["head", "neck", *(f"tail{i:02d}" for i in range(20))])),
    "octopus": (
        "other",
        [("body", (0, 0, 0.3), (0, 0, 0.6), "")]
        + [b for i in range(4) for b in pair((LR, [f"tentacle_{i}_{j}_{{}}" for j in range(5)]),
           [(0.1 + 0.2 * j, (i - 1.5) * 0.2 * j, 0.3 - 0.06 * j) for j in range(6)], "body")],
    ),  # fmt: skip
    "drone with arms": (
        "other",
        [("Head", (0, 0, 0.2), (0, 0, 0.5), "")]
        + pair((LR, ["Shoulder_{}", "UpperArm_{}", "LowerArm_{}", "Hand_{}"]),
               [(0.3 + 0.2 * i, 0, 0.3) for i in range(5)], "Head"),
    ),
    "skeleton whose arms are copies of its legs": (
        "human",
        chain(["Hips", "Torso", "Neck", "Head"], [(0, 0, z) for z in (1.7, 2.3, 3.5, 3.8, 5.2)])
        + pair((LR, ["{}.UpperLeg", "{}.LowerLeg"]), ((0.5, 0, 1.4), (0.55, 0, 0.8), (0.6, 0, 0)), "Hips")
        + pair((LR, ["{}.UpperLeg.001", "{}.LowerLeg.001"]), ((0.7, 0, 3.1), (1.5, 0, 3.1), (2.3, 0, 3.1)), "Torso"),
    ),
    "hand": (
        "other",
        [("palm", (0, 0, 0), (0, 0.1, 0), "")]
        + [b for f, x in (("index", 0.0), ("middle", 0.02), ("ring", 0.04))
           for b in chain([f"{f}_{j}" for j in range(3)], [(x, 0.1 + 0.04 * j, 0) for j in range(4)], "palm")],
    ),  # fmt: skip
    "t-rex": (
        "other",
        chain(["Hips", "Spine_1", "Spine_2", "Neck", "Head"],
              ((0, 0.4, 0.8), (0, 0.1, 0.9), (0, -0.3, 1.2), (0, -0.5, 1.4), (0, -0.7, 1.7), (0, -1.2, 1.7)))
        + pair((LR, ["Front_Leg_Upper_{}", "Front_Leg_Lower_{}", "Hand_{}"]),
               ((0.15, -0.4, 1.2), (0.2, -0.5, 1.05), (0.2, -0.6, 1.0), (0.2, -0.7, 1.0)), "Spine_2")
        + pair((LR, ["Back_Leg_Upper_{}", "Back_Leg_Lower_{}", "Back_Leg_Ankle_{}", "Back_Leg_Foot_{}"]),
               ((0.2, 0.3, 0.9), (0.25, 0.05, 0.6), (0.25, 0.3, 0.4), (0.25, 0.2, 0.1), (0.25, 0.0, 0.05)), "Hips"),
    ),
    "car": ("other", [("chassis", (0, 1, 0.5), (0, -1, 0.5), "")]
            + [b for y in (-0.8, 0.8) for b in pair((LR, [f"wheel_{'f' if y < 0 else 'b'}_{{}}"]),
               ((0.6, y, 0.3), (0.8, y, 0.3)), "chassis")]),
}  # fmt: skip
TURNS = {
    "as built": Matrix(),
    "facing X": Matrix.Rotation(math.radians(90), 4, "Z"),
    "Y up, in centimeters": Matrix.Rotation(math.radians(-90), 4, "X") @ Matrix.Scale(100, 4),
}


def muscles():
    return {found.name for found in bpy.data.objects if found.sinew.tissue.kind == "MUSCLE"}


@pytest.mark.parametrize("turn", TURNS)
@pytest.mark.parametrize("creature", CREATURES)
def test_the_kind_of_a_creature_in_any_convention_and_any_axes(creature, turn):
    expected, bones = CREATURES[creature]
    rig = built(bones, TURNS[turn])
    if turn.startswith("Y up"):
        rig.matrix_world = TURNS[turn].inverted()
    found = kind.kind_of_character(rig)
    assert found.name == expected, found.text
    assert found.sureness > 0.4


@pytest.mark.parametrize("convention", NAMES)
def test_humans_of_all_conventions_are_humans(convention):
    found = kind.kind_of_character(human_of(*named(convention)))
    assert found.name == "human" and found.sureness > 0.8, found.text


def test_the_text_says_what_was_found_and_how_sure_it_is():
    text = kind.kind_of_character(built(SPIDER)).text
    assert text.startswith("an insect, a spider or a crab (9") and "4 pairs of legs by name" in text


@pytest.mark.parametrize("spine", [row(["a", "b", "c", "d", "e"]), LEVEL_FISH])
def test_a_level_spine_without_limbs_is_a_fish_where_an_object_is_named_so(spine):
    assert kind.kind_of_character(built(spine, name="Trout")).name == "fish"
    assert kind.kind_of_character(built(spine, name="Thing")).name == "other"


def test_a_fish_without_fins_and_with_a_few_bones_has_all_parts_of_its_body():
    rig = built(LEVEL_FISH, name="Trout")
    body = segments.recognise(rig, kind="fish")
    assert all(body.has(part, "") for part in ("head", "chest", "abdomen", "pelvis", "tail_base", "tail_middle", "tail_tip"))
    assert body.segment("abdomen", "").bones == ("spine3",) and body.segment("tail_tip", "").bones == ("tail",)
    assert body.segment("chest", "").outer.x > 0.99 and body.segment("head", "").axis.y < -0.99
    bpy.ops.sinew.add_muscles()
    assert "Epaxialis, fifth part.L" in muscles()


# Add Muscles


@pytest.mark.parametrize("creature", ["dog", "horse, front and back", "bird", "fish", "spider", "snake", "t-rex"])
def test_muscles_are_chosen_by_kind(creature, capfd):
    expected, bones = CREATURES[creature]
    rig = built(bones)
    assert bpy.ops.sinew.add_muscles() == {"FINISHED"}
    printed = capfd.readouterr().out
    assert f"looks like {kind.LABELS[expected]}" in printed
    preset = choice.preset_of(expected)
    if preset:
        rules = {rule.name for rule in preset_file.read(preset).tissues}
        assert {name.removesuffix(".L").removesuffix(".R") for name in muscles()} <= rules
    else:
        assert "muscles added to" in printed and all(
            name.split()[0] in ("Flexor", "Extensor", "Abductor", "Adductor") for name in muscles()
        )
    assert len(muscles()) >= 12
    assert all(empty.parent == rig for empty in characters.tissues_of(rig))


def test_the_creature_can_be_chosen():
    built(DOG)
    bpy.ops.sinew.add_muscles(creature="other")
    assert "Flexor Tibia_L" in muscles()


def test_a_body_that_lacks_most_parts_of_the_preset_gets_muscles_at_its_joints(monkeypatch, capfd):
    monkeypatch.setattr(add_muscles, "FEWEST_OF_PRESET", 1.0)
    built(DOG)
    bpy.ops.sinew.add_muscles()
    assert "has parts for only" in capfd.readouterr().out
    assert "Flexor Tibia_L" in muscles()


def test_a_choice_that_does_not_fit_falls_back_to_the_joints(capfd):
    built(row(["a", "b", "c", "d"]))
    bpy.ops.sinew.add_muscles(creature="bird")
    assert "The preset bird can't be used" in capfd.readouterr().out
    assert len(muscles()) == 12


def test_add_muscles_is_undone():
    built(DOG)
    bpy.ops.ed.undo_push(message="Start")
    bpy.ops.sinew.add_muscles()
    assert muscles()
    bpy.ops.ed.undo_push(message="Added")
    bpy.ops.ed.undo()
    assert not muscles() and "Rig" in bpy.data.objects


def test_a_preset_on_the_wrong_creature_proposes_the_right_one(capfd):
    built(DOG)
    bpy.ops.sinew.add_preset(name="human")
    assert "it stands on four legs. The preset human is for humans; try the preset quadruped" in capfd.readouterr().out
    human_of(*named("German"))
    bpy.ops.sinew.add_preset(name="quadruped")
    assert "doesn't look like an animal on four legs: it looks like a human" in capfd.readouterr().out


def test_a_dog_without_shoulder_blades_gets_its_shoulder_muscles():
    bones = [bone for bone in DOG if not bone[0].startswith("Scapula")]
    bones = [(name, head, tail, "Chest" if parent.startswith("Scapula") else parent) for name, head, tail, parent in bones]
    rig = built(bones)
    blade = segments.recognise(rig, kind="quadruped").segment("shoulder_girdle", "L")
    assert blade.bones == ("Chest",) and blade.end == segments.recognise(rig).segment("upper_arm", "L").start
    assert blade.start.z > blade.end.z and blade.start.y > blade.end.y
    bpy.ops.sinew.add_muscles()
    assert {"Deltoideus, acromial part.L", "Triceps brachii, long head.R"} <= muscles()
    assert "Rhomboideus thoracis.L" not in muscles()  # both of its ends would be on the chest


def test_wings_are_arms_and_a_fish_is_cut_by_length():
    bird_rig = built(BIRD)
    body = segments.recognise(bird_rig, kind="bird")
    assert [body.segment(role, "L").bones[0] for role in ("upper_arm", "forearm", "hand")] == [
        "Wing1_L",
        "Wing2_L",
        "Wing3_L",
    ]
    assert body.segment("upper_arm", "L").front.y < -0.8 and body.segment("upper_arm", "R").outer.z > 0.8
    for name in ("fish", "fish from the tail"):
        body = segments.recognise(built(CREATURES[name][1]), kind="fish")
        assert body.segment("head", "").axis.y < -0.9 and body.segment("tail_base", "").axis.y > 0.9
        assert body.segment("chest", "").end.y == pytest.approx(body.segment("head", "").start.y, abs=1e-5)


@pytest.mark.parametrize("seed", range(40))
def test_random_armatures_have_a_kind_and_take_muscles_or_refuse_in_words(seed):
    chance = random.Random(seed)
    words = (*WORDS, "fin", "feather", "antenna", "tentacle", "hoof", "spine", "翼", "ひれ") if seed % 3 else ("x",)
    bones = []
    for index in range(chance.choice((0, 1, 2, 4, 9, 20, 45))):
        name = f"{'_'.join(chance.sample(words, min(len(words), chance.randint(1, 3))))}.{index}"
        parent = chance.choice(bones)[0] if bones and chance.random() < 0.85 else ""
        scale = 10.0 ** chance.choice((-6, -2, 0, 0, 0, 3)) if seed % 4 == 0 else 1.0
        head = Vector([round(chance.uniform(-1, 1), chance.choice((0, 1, 5))) * scale for _ in range(3)])
        bones.append((name, head, head + Vector([chance.uniform(-1, 1) * scale for _ in range(3)]), parent))
    rig = built(bones)
    rig.scale = chance.choice(((1, 1, 1), (0.01, 0.01, 0.01), (1, 2, -1), (0, 0, 0)))
    bpy.context.view_layer.update()
    found = kind.kind_of_character(rig)
    assert found.name in kind.KINDS and 1 / len(kind.KINDS) <= found.sureness <= 1.0
    try:
        bpy.ops.sinew.add_muscles(creature=chance.choice(("AUTO", "AUTO", *kind.KINDS)))
    except RuntimeError as refused:
        assert "Traceback" not in str(refused), refused
    select(rig)
