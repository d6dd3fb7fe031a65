# SPDX-License-Identifier: GPL-3.0-or-later
"""The digits of a hand, by the names of their bones, and the preset Hand on them."""

import bpy
import pytest
from bl_ext.user_default.sinew.errors import SinewError
from bl_ext.user_default.sinew.muscles.placing.place import placement, preset_file
from bl_ext.user_default.sinew.muscles.placing.recognise import segments
from bl_ext.user_default.sinew.muscles.placing.recognise.body_parts import DIGIT_ROLES
from test_preset_placement import assert_mirrored, asymmetry_m


@pytest.fixture
def human(rigify):
    bpy.ops.object.armature_human_metarig_add()
    return bpy.context.object


def require_all_digits(rig):
    body = segments.recognise(rig)
    assert all(body.has(role, side) for role in DIGIT_ROLES for side in ("L", "R"))
    for role in DIGIT_ROLES:
        left, right = body.segment(role, "L"), body.segment(role, "R")
        # the metarig of Blender 4.5 itself differs between left and right by 9 micrometers
        assert left.length == pytest.approx(right.length, abs=2e-5)
        assert left.front.dot(left.axis) == pytest.approx(0.0, abs=1e-5)
    lengths = {role: body.segment(role, "L").length for role in DIGIT_ROLES}
    assert lengths["middle_proximal"] > lengths["middle_middle"] > 0.8 * lengths["middle_distal"]
    assert lengths["middle_metacarpal"] > lengths["middle_proximal"]


def test_all_digits_of_rigify(human):
    require_all_digits(human)


def test_all_digits_of_makehuman(real_body):
    require_all_digits(real_body[1])


def test_fingers_curl_toward_the_palm(human):
    body = segments.recognise(human)
    palm = body.segment("hand", "L").front
    for finger in ("index", "middle", "ring", "little"):
        assert body.segment(f"{finger}_proximal", "L").front.dot(palm) > 0.7


def test_a_hand_without_finger_bones_gets_no_digits(human):
    for bone in ("f_index.01.L", "f_middle.01.L", "f_ring.01.L", "f_pinky.01.L", "thumb.01.L"):
        for part in [human.data.bones[bone], *human.data.bones[bone].children_recursive]:
            part.name = f"part {part.name[-4:]}"
    body = segments.recognise(human)
    assert not any(body.has(role, "L") for role in DIGIT_ROLES)


def test_the_hand_has_27_bones_and_all_intrinsic_muscles(human):
    shapes = placement.place(preset_file.read("hand"), segments.recognise(human), None)
    left = [shape for shape in shapes if shape.name.endswith(".L")]
    assert sum(shape.kind == "BONE" for shape in left) == 27
    intrinsic = ("pollicis", "digiti minimi", "Interosseus", "Lumbricalis")
    muscles = [shape for shape in left if shape.kind == "MUSCLE" and any(word in shape.name for word in intrinsic)]
    assert len([shape for shape in muscles if "longus" not in shape.name]) == 19
    assert_mirrored(shapes, 1e-5 + 2 * asymmetry_m(human), 1e-3 + 100 * asymmetry_m(human))


def test_a_preset_has_its_own_proportions(rigify):
    bpy.ops.object.armature_cat_metarig_add()
    body = segments.recognise(bpy.context.object)
    cat, toad = (
        next(shape for shape in placement.place(preset_file.read(name), body, None) if shape.name == "Head stuffing")
        for name in ("cat", "toad")
    )
    assert toad.semi_axes.y > 1.5 * cat.semi_axes.y


def test_wrong_proportions_are_refused(tmp_path):
    text = (preset_file.FOLDER / "toad.json").read_text(encoding="utf-8")
    path = tmp_path / "mine.json"
    path.write_text(text.replace('"side": 0.74', '"side": 7'), encoding="utf-8")
    with pytest.raises(SinewError, match=r"mine\.json, line \d+: .*'proportions.chest.side' must be .* 0\.01 to 3"):
        preset_file.read(path)
    path.write_text(text.replace('"chest": {"front"', '"torso": {"front"'), encoding="utf-8")
    with pytest.raises(SinewError, match=r"mine\.json, line \d+: .*'proportions.torso' must be one of"):
        preset_file.read(path)
