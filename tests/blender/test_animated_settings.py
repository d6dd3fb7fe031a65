# SPDX-License-Identifier: GPL-3.0-or-later
"""Every setting that can be animated counts as it is evaluated: in a render as in the viewport, keyed, driven or in the NLA.

Each test compares with the same evaluation of a file in which the setting has the value as a constant.
"""

import bpy
import numpy as np
import pytest
from bl_ext.user_default.sinew.live import handlers, session
from bl_ext.user_default.sinew.scene import characters
from conftest import FLEXOR, add_muscle, bend, bind, evaluated_points, make_arm, select
from evaluations import rendered_from_to

FRAME = 10  # the window stays at frame 1
_scene_count = 1
ANIMATED_TYPES = {"BOOLEAN", "INT", "FLOAT", "ENUM"}
# (value at frame 1, value at frame 10) of each setting that can be animated
TISSUE = {
    "origin_tendon": (0.0, 0.05),
    "insertion_tendon": (0.0, 0.05),
    "volume_keeping": (1.0, 0.2),
    "tension": (0.0, 1.0),
}
SKIN = {
    "anchoring": ("BLENDED", "NEAREST"),
    "motion_source": ("SWELLING", "FULL"),
    "scale_fat": (False, True),
    "falloff": (0.0, 0.03),
    "muscle_influence": (3.0, 0.0),
    "elastic": (True, False),
    "iterations": (10, 1),
    "energy": ("AS_RIGID_AS_POSSIBLE", "SPRINGS"),
    "anchor_stiffness": (1.0, 0.2),
    "edge_stiffness": (1.0, 4.0),
    "slack": (0.0, 0.02),
    "fat_sliding": (0.0, 1.0),
    "contacts": (True, False),
}
BONE = {
    "anchor_stiffness": (1.0, 0.2),
    "edge_stiffness": (1.0, 4.0),
    "slack": (1.0, 0.0),
    "relaxation": (1.0, 0.0),
    "muscle_influence": (1.0, 3.0),
    "fat_sliding": (1.0, 0.0),
    "keep_volume": (1.0, 0.0),
    "crease": (1.0, 0.0),
    "contact": (1.0, 0.0),
}
GOAL = {"position_weight": (1.0, 0.0), "orientation_weight": (0.0, 1.0), "look_at_weight": (0.0, 1.0)}
# of the Empty of a muscle
TRANSFORMS = {
    "location": ((0.0, 0.0, 0.0), (0.03125, 0.015625, -0.03125)),
    "rotation_euler": ((0.0, 0.0, 0.0), (0.25, 0.375, 0.125)),
    "rotation_quaternion": ((1.0, 0.0, 0.0, 0.0), (0.9, 0.1, 0.3, 0.1)),
    "rotation_axis_angle": ((0.0, 0.0, 1.0, 0.0), (0.4, 0.0, 1.0, 0.0)),
    "rotation_mode": ("XYZ", "ZYX"),
    "scale": ((0.03, 0.03, 0.12), (0.045, 0.02, 0.1)),
    "empty_display_size": (1.0, 1.3),
}
MODIFIER = {
    "use_deform_preserve_volume": (False, True),
    "show_render": (True, False),
    "show_viewport": (True, False),
}
MODE_OF = {"rotation_quaternion": "QUATERNION", "rotation_axis_angle": "AXIS_ANGLE"}


@pytest.fixture
def character():
    """(mesh, rig, muscle): an arm that is bent so far that skin meets, with a wide muscle that has a via point."""
    skin, rig = make_arm()
    muscle = add_muscle(rig, around=FLEXOR)
    muscle.scale.xy *= 2.0
    select(muscle)
    bpy.ops.sinew.add_via_point()
    bind(skin)
    # settings with which every other setting has an effect
    skin.sinew.skin.slack, skin.sinew.skin.fat_sliding, skin.sinew.skin.muscle_influence = 0.01, 0.5, 3.0
    bend(rig, 2.8)
    return skin, rig, muscle


def animated(group):
    """The names of the settings in a group that Blender lets a user key."""
    return {
        found.identifier
        for found in group.bl_rna.properties
        if found.is_animatable and not found.is_readonly and found.type in ANIMATED_TYPES
    }


def test_all_settings_that_can_be_animated_are_tested(character):
    skin, rig, muscle = character
    goal = bpy.data.objects.new("Goal", None)
    for group, tested in (
        (muscle.sinew.tissue, TISSUE),
        (skin.sinew.skin, SKIN),
        (rig.pose.bones["lower"].sinew, BONE),
        (goal.sinew.goal, GOAL),
        (rig.sinew.rig, ()),
        (skin.sinew.skin.growth, ()),
        (skin.sinew.skin.baked_keys.add(), ()),
        (muscle.sinew.tissue.wraps.add(), ()),
        (muscle.sinew, ()),
    ):
        assert animated(group) == set(tested), type(group).__name__


def path_of(owner, name):
    """The data path of a setting. Blender can't find that of a bone's settings by itself."""
    is_of_bone = owner.bl_rna.identifier == "SinewBoneSettings"
    return f'pose.bones["lower"].sinew.{name}' if is_of_bone else owner.path_from_id(name)


def key(owner, name, start, end):
    for frame, value in ((1, start), (FRAME, end)):
        setattr(owner, name, value)
        owner.id_data.keyframe_insert(path_of(owner, name), frame=frame)


def drive(owner, name, start, end):
    drivers = owner.id_data.driver_add(path_of(owner, name))
    drivers = drivers if isinstance(drivers, list) else [drivers]
    of_components = zip(drivers, *(np.ravel(_number(owner, name, value)) for value in (start, end)), strict=True)
    for curve, before, after in of_components:
        curve.keyframe_points.clear()  # Blender maps the value with a line through two points, which rounds
        curve.driver.expression = f"{float(before)} if frame < {FRAME} else {float(after)}"


def key_in_strip(owner, name, start, end):
    """Keys in a strip that plays its action at half speed, beginning at frame 1."""
    for frame, value in ((1, start), (1 + (FRAME - 1) / 2, end)):
        setattr(owner, name, value)
        owner.id_data.keyframe_insert(path_of(owner, name), frame=frame)
    animation = owner.id_data.animation_data
    action, slot = animation.action, animation.action_slot
    strip = animation.nla_tracks.new().strips.new("slow", 1, action)
    strip.action_slot, strip.scale = slot, 2.0
    animation.action = None


def _number(owner, name, value):
    known = owner.bl_rna.properties[name]
    return known.enum_items[value].value if known.type == "ENUM" else value


ANIMATIONS = (key, drive, key_in_strip)


def read_again():
    session.forget()
    characters.forget()
    handlers.mark_all_dirty()


@pytest.fixture(autouse=True, params=[1, pytest.param(2, marks=pytest.mark.slow)], ids=["one scene", "two scenes"])
def scene_count(request):
    """How many scenes `both` renders."""
    global _scene_count
    _scene_count = request.param


def other_scene():
    """A scene that shows the same objects. The window does not show it."""
    found = bpy.data.scenes.get("Other")
    if found is None:
        found = bpy.data.scenes.new("Other")
        for each in bpy.context.scene.collection.objects:
            found.collection.objects.link(each)
        for each in bpy.context.scene.collection.children:
            found.collection.children.link(each)
    return found


def both(skin, tmp_path):
    """The points of frame 10, rendered while the window shows frame 1, and in the window.

    The render has the frame and a subframe of motion blur, in this scene and, in the slow run, in another one.
    """
    bpy.context.scene.frame_set(1)
    of_window = evaluated_points(skin)
    of_renders = []
    for scene in (bpy.context.scene, other_scene())[:_scene_count]:
        of_renders += [points for _frame, points in sorted(rendered_from_to(skin, tmp_path, FRAME, scene=scene).items())]
    assert len(of_renders) == 2 * _scene_count
    bpy.context.view_layer.update()
    assert np.array_equal(evaluated_points(skin), of_window)  # the renders left the window as it was
    bpy.context.scene.frame_set(FRAME)
    return np.stack(of_renders), evaluated_points(skin)


def check(skin, owner, name, values, tmp_path, has_effect=(True, True)):
    """The value at frame 10 counts, however it is animated. has_effect: in the render, and in the window."""
    start, end = values
    setattr(owner, name, start)
    read_again()
    before = both(skin, tmp_path)
    setattr(owner, name, end)
    read_again()
    expected = both(skin, tmp_path)
    assert tuple(not np.array_equal(*points) for points in zip(before, expected)) == has_effect
    for animate in ANIMATIONS:
        animate(owner, name, start, end)
        shown = both(skin, tmp_path)
        owner.id_data.animation_data_clear()
        assert [np.abs(a - b).max() for a, b in zip(shown, expected)] == [0.0, 0.0], animate.__name__


@pytest.mark.parametrize("name", TISSUE)
def test_settings_of_a_muscle(character, tmp_path, name):
    skin, _rig, muscle = character
    check(skin, muscle.sinew.tissue, name, TISSUE[name], tmp_path)


@pytest.mark.parametrize("name", TRANSFORMS)
def test_transforms_of_a_muscle(character, tmp_path, name):
    skin, _rig, muscle = character
    muscle.rotation_euler = (0.3, 0.4, 0.5)
    muscle.rotation_mode = MODE_OF.get(name, "XYZ")
    check(skin, muscle, name, TRANSFORMS[name], tmp_path)


def test_location_of_a_via_point(character, tmp_path):
    skin, _rig, _muscle = character
    via = next(found for found in bpy.data.objects if found.sinew.tissue.kind == "VIA")
    start = tuple(via.location)
    check(skin, via, "location", (start, (start[0], start[1] + 0.03, start[2])), tmp_path)


@pytest.mark.parametrize("name", SKIN)
def test_settings_of_a_skin(character, tmp_path, name):
    skin, _rig, _muscle = character
    check(skin, skin.sinew.skin, name, SKIN[name], tmp_path)


@pytest.mark.parametrize("name", BONE)
def test_settings_of_a_bone(character, tmp_path, name):
    skin, rig, _muscle = character
    check(skin, rig.pose.bones["lower"].sinew, name, BONE[name], tmp_path)


@pytest.mark.parametrize("name", MODIFIER)
def test_settings_of_the_armature_modifier(character, tmp_path, name):
    skin, _rig, _muscle = character
    has_effect = {"show_render": (True, False), "show_viewport": (False, True)}.get(name, (True, True))
    check(skin, skin.modifiers["Armature"], name, MODIFIER[name], tmp_path, has_effect)


@pytest.mark.parametrize("animate", ANIMATIONS, ids=lambda animate: animate.__name__)
def test_other_shape_keys_and_modifiers_of_a_live_skin_are_rendered_as_animated(character, tmp_path, animate):
    """Blender copies them from the window's frame when a handler has written the mesh."""
    skin, _rig, _muscle = character
    skin.shape_key_add(name="Basis")
    smile = skin.shape_key_add(name="Smile")
    for point in smile.data:
        point.co.z += 0.1
    displace = skin.modifiers.new("Displace", "DISPLACE")
    for owner, name, values in (
        (smile, "value", (0.5, 1.0)),
        (displace, "strength", (0.0, 0.25)),
        (smile, "mute", (False, True)),
    ):
        setattr(owner, name, values[1])
        expected = both(skin, tmp_path)
        animate(owner, name, *values)
        shown = both(skin, tmp_path)
        owner.id_data.animation_data_clear()
        setattr(owner, name, values[0])
        assert [np.abs(a - b).max() for a, b in zip(shown, expected)] == [0.0, 0.0], name
        assert not np.array_equal(both(skin, tmp_path)[0], expected[0]), name
