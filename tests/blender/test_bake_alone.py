# SPDX-License-Identifier: GPL-3.0-or-later
"""A bake evaluates the character alone, in a scene of its own, and gives what the whole scene would give."""

import tracemalloc

import bpy
import numpy as np
import pytest
from bl_ext.user_default.sinew.bake.scratch import character_scene
from bl_ext.user_default.sinew.errors import SinewError
from conftest import FLEXOR, add_muscle, bend, bind, evaluated_points, make_arm, select


def bake(skin):
    """The baked keys by name, (vertices, 3) each, with the values of their curves."""
    select(skin)
    assert bpy.ops.sinew.bake_shape_keys(frame_start=1, frame_end=12) == {"FINISHED"}
    keys = skin.data.shape_keys.key_blocks
    shapes = {}
    for name in [baked.name for baked in skin.sinew.skin.baked_keys]:
        shapes[name] = np.empty(3 * len(skin.data.vertices), np.float32)
        keys[name].points.foreach_get("co", shapes[name])
    return shapes


@pytest.fixture
def constrained(waving):
    """(mesh, rig): the lower bone also follows an animated Empty outside of the character."""
    skin, rig = waving
    target = bpy.data.objects.new("Target", None)
    bpy.context.scene.collection.objects.link(target)
    for frame, angle in ((1, 0.0), (12, 0.5)):
        target.rotation_euler.z = angle
        target.keyframe_insert("rotation_euler", frame=frame)
    constraint = rig.pose.bones["lower"].constraints.new("COPY_ROTATION")
    constraint.target, constraint.mix_mode = target, "ADD"
    bpy.context.scene.frame_set(1)
    return skin, rig


def test_alone_as_in_the_whole_scene(constrained, monkeypatch):
    skin, _rig = constrained
    alone = bake(skin)
    monkeypatch.setattr(character_scene, "depends_on_scene", lambda _scene: True)
    skin.sinew.skin.live = True
    whole = bake(skin)
    assert len(alone) > 3 and alone.keys() == whole.keys()
    assert all(np.array_equal(alone[name], whole[name]) for name in alone)


def test_other_objects_are_not_evaluated_and_no_scene_stays(constrained):
    skin, _rig = constrained
    cube = bpy.data.objects.new("Other", bpy.data.meshes.new("Other"))
    bpy.context.scene.collection.objects.link(cube)
    seen = set()

    def look(scene, depsgraph):
        seen.add((scene.name, cube.evaluated_get(depsgraph).is_evaluated))

    assert not character_scene.depends_on_scene(bpy.context.scene)
    skins = [skin]
    with character_scene.visit_frames_of_characters(bpy.context.scene, skins) as evaluate:
        look(bpy.data.scenes["Sinew Bake"], evaluate(4.5))
    assert seen == {("Sinew Bake", False)} and len(bpy.data.scenes) == 1


def test_the_frame_and_a_pose_without_keys_stay(waving):
    skin, rig = waving
    bpy.context.scene.frame_set(7)
    rig.pose.bones["upper"].location.z = 0.1
    bpy.context.view_layer.update()
    shown = evaluated_points(skin)
    with character_scene.visit_frames_of_characters(bpy.context.scene, [skin]) as evaluate:
        evaluate(12.0)
    assert bpy.context.scene.frame_current == 7 and rig.pose.bones["upper"].location.z == pytest.approx(0.1)
    assert np.array_equal(evaluated_points(skin), shown)


@pytest.mark.parametrize("cause", ["driver", "handler"])
def test_what_may_depend_on_the_scene_is_baked_in_it(waving, cause):
    _skin, rig = waving
    if cause == "driver":
        driver = rig.pose.bones["upper"].driver_add("location", 0).driver
        variable = driver.variables.new()
        variable.targets[0].id_type = "SCENE"
        variable.targets[0].id, variable.targets[0].data_path = bpy.context.scene, "frame_current"
        assert character_scene.depends_on_scene(bpy.context.scene)
        return

    def foreign(*_):
        pass

    bpy.app.handlers.frame_change_post.append(foreign)
    try:
        assert character_scene.depends_on_scene(bpy.context.scene)
    finally:
        bpy.app.handlers.frame_change_post.remove(foreign)


def test_a_deleted_scene_ends_the_bake_in_words(waving):
    skin, _rig = waving
    own = character_scene.visit_frames_of_characters(bpy.context.scene, [skin])
    with pytest.raises(SinewError, match="bake again"), own as evaluate:
        bpy.data.scenes.remove(bpy.data.scenes["Sinew Bake"])
        evaluate(2.0)


@pytest.mark.one_blender
def test_the_samples_of_a_bake_are_not_in_memory():
    skin, rig = make_arm(rings=80, around=60)
    add_muscle(rig, around=FLEXOR)
    skin.sinew.skin.elastic = False
    bind(skin)
    rig.pose.bones["lower"].rotation_mode = "XYZ"
    bend(rig, 1.2)
    rig.pose.bones["lower"].keyframe_insert("rotation_euler", frame=1)
    select(skin)
    peaks = []
    for last in (10, 60):
        tracemalloc.start()
        assert bpy.ops.sinew.bake_shape_keys(frame_start=1, frame_end=last) == {"FINISHED"}
        peaks.append(tracemalloc.get_traced_memory()[1])
        tracemalloc.stop()
        skin.sinew.skin.live = True
    samples_of_50_frames = 2 * 50 * len(skin.data.vertices) * 12
    assert peaks[1] - peaks[0] < 0.2 * samples_of_50_frames
