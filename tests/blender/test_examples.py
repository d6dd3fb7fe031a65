# SPDX-License-Identifier: GPL-3.0-or-later
"""The examples of the documentation: Python runs, and the command line is understood."""

import shlex

import bpy
import numpy as np
import pytest
from bl_ext.user_default.sinew import command_line
from build.layout import ROOT
from docs_site import pages

PAGES = [page for page in pages.all_pages() if any(block.language == "python" for block in pages.blocks_of(page))]


@pytest.fixture
def character(arm):
    """The character that the pages name: a mesh `Body` on an armature `Rig` with an upper arm, a forearm and a hand."""
    skin, rig = arm
    skin.name, rig.name = "Body", "Rig"
    bpy.context.view_layer.objects.active = rig
    bpy.ops.object.mode_set(mode="EDIT")
    bones = rig.data.edit_bones
    hand = bones.new("hand.L")
    hand.head, hand.tail, hand.parent = bones["lower"].tail, (0.7, 0, 0), bones["lower"]
    bpy.ops.object.mode_set(mode="OBJECT")
    rig.data.bones["upper"].name, rig.data.bones["lower"].name = "upper_arm.L", "forearm.L"
    rig.data.bones["hand.L"].use_deform = False
    return skin, rig


def add_muscle_and_bind(skin, rig):
    """The muscle and the bound skin that pages other than Scripting start from."""
    bpy.context.view_layer.objects.active = rig
    bpy.ops.sinew.add_tissue(kind="MUSCLE", origin_bone="upper_arm.L", insertion_bone="forearm.L")
    bpy.context.view_layer.objects.active = skin
    bpy.ops.sinew.bind()


@pytest.mark.parametrize("page", PAGES, ids=pages.name_of)
def test_the_examples_of_a_page_run_in_order(character, page):
    if page.name != "scripting.md":
        add_muscle_and_bind(*character)
    names = {"bpy": bpy}
    for block in pages.blocks_of(page):
        if block.language == "python":
            exec(compile("\n" * (block.line - 1) + block.code, str(page), "exec"), names)


def command_lines():
    for page in pages.all_pages():
        for block in pages.blocks_of(page):
            if block.language == "sh":
                yield from (line for line in block.code.splitlines() if line.startswith("blender "))


@pytest.mark.parametrize("line", list(command_lines()))
def test_the_command_line_understands_the_examples(line):
    words = shlex.split(line)
    assert words[:5] == ["blender", "-y", "--command", "sinew", words[4]]
    assert command_line._parser().parse_args(words[4:]).run


def test_a_wrong_command_line_is_not_understood():
    with pytest.raises(SystemExit):
        command_line._parser().parse_args(["bake", "a.blend", "--no-such-option"])


def test_the_pages_of_operators_and_settings_are_up_to_date():
    from build import operators_page, settings_page

    for module in (operators_page, settings_page):
        written = (ROOT / "docs" / module.PAGE.name).read_text(encoding="utf-8")
        command = f"Run python3 scripts/run_in_blender.py scripts/build/{module.__name__.rpartition('.')[2]}.py"
        assert module.text() == written, command


def test_the_garment_of_the_page_follows_the_live_skin(character):
    """In a bent arm, Sinew moves the skin by millimetres, and the garment stays beside it."""
    skin, rig = character
    add_muscle_and_bind(skin, rig)
    page = next(page for page in PAGES if page.name == "clothes.md")
    for block in pages.blocks_of(page):
        if block.language == "python":
            exec(compile(block.code, str(page), "exec"), {"bpy": bpy})
    skin.modifiers["Armature"].use_deform_preserve_volume = False
    forearm = rig.pose.bones["forearm.L"]
    forearm.rotation_mode = "XYZ"
    forearm.rotation_euler.x = 1.6
    bpy.context.scene.frame_set(2)
    live, garment = points_of(skin), points_of(bpy.data.objects["Shirt"])
    skin.sinew.skin.live = False
    bpy.context.scene.frame_set(3)
    unmoved = points_of(skin)
    assert np.linalg.norm(live - unmoved, axis=1).max() > 0.002
    distance = np.linalg.norm(garment - live, axis=1)
    assert 0.004 < np.median(distance) < 0.006
    assert np.percentile(distance, 95) < 0.008


def points_of(skin):
    depsgraph = bpy.context.evaluated_depsgraph_get()
    mesh = skin.evaluated_get(depsgraph).data
    points = np.empty(3 * len(mesh.vertices), np.float32)
    mesh.vertices.foreach_get("co", points)
    return points.reshape(-1, 3)
