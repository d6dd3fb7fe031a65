# SPDX-License-Identifier: GPL-3.0-or-later
"""Baking frames to shape keys: the keys play as live, within the tolerance, and together with other keys."""

import bpy
import numpy as np
import pytest
from conftest import evaluated_points, points_over, select


def bake(skin, **settings):
    select(skin)
    defaults = {"frame_start": 1, "frame_end": 12, "step": 1, "tolerance": 0.0, "prefix": "sinew_"}
    return bpy.ops.sinew.bake_shape_keys(**defaults | settings)


def test_baked_keys_play_as_live(waving):
    skin, _rig = waving
    live = points_over(skin, range(1, 13))
    assert bake(skin) == {"FINISHED"}
    # the first frame is the rest pose and needs no key
    assert [key.name for key in skin.data.shape_keys.key_blocks] == ["Basis", *(f"sinew_{f:04d}" for f in range(2, 13))]
    assert not skin.sinew.skin.live and 0.0 <= skin.sinew.skin.bake_error_mm < 0.3  # between frames
    assert np.abs(points_over(skin, range(1, 13)) - live).max() < 1e-6


def test_baked_keys_play_without_sinew(waving):
    import addon_utils

    skin, _rig = waving
    live = points_over(skin, range(1, 13))
    bake(skin)
    addon_utils.disable("bl_ext.user_default.sinew")
    assert np.abs(points_over(skin, range(1, 13)) - live).max() < 1e-6


def test_baked_keys_leave_other_keys_alone(waving):
    skin, _rig = waving
    skin.shape_key_add(name="Basis")
    own = skin.shape_key_add(name="Smile")
    for point in own.points:
        point.co.z += 0.01
    own.value = 0.5
    live = points_over(skin, range(1, 13))
    bake(skin)
    assert np.abs(points_over(skin, range(1, 13)) - live).max() < 1e-6
    assert own.value == 0.5 and skin.data.shape_keys.key_blocks[1].name == "Smile"


def test_every_third_frame(waving):
    skin, _rig = waving
    live = points_over(skin, (1, 4, 7, 10))
    bake(skin, step=3)
    assert [key.name for key in skin.data.shape_keys.key_blocks] == ["Basis", "sinew_0004", "sinew_0007", "sinew_0010"]
    assert np.abs(points_over(skin, (1, 4, 7, 10)) - live).max() < 1e-6


def test_a_new_bake_replaces_the_old(waving):
    skin, _rig = waving
    bake(skin)
    bake(skin, frame_end=6)
    assert len(skin.data.shape_keys.key_blocks) == 6
    curves = [
        curve.data_path
        for layer in skin.data.shape_keys.animation_data.action.layers
        for strip in layer.strips
        for bag in strip.channelbags
        for curve in bag.fcurves
    ]
    assert len(curves) == 5 == len(set(curves))


def test_live_again_mutes_the_keys(waving):
    skin, _rig = waving
    live = points_over(skin, (6, 12))
    bake(skin)
    skin.sinew.skin.live = True
    assert np.abs(points_over(skin, (6, 12)) - live).max() < 1e-6


@pytest.mark.parametrize(
    "settings, words",
    [
        ({"frame_start": 9, "frame_end": 3}, "before the first"),
        ({"prefix": "p" * 60}, "longer than"),
    ],
)
def test_impossible_bakes_are_refused(waving, settings, words):
    skin, _rig = waving
    with pytest.raises(RuntimeError, match=words):
        bake(skin, **settings)
    assert skin.data.shape_keys is None and skin.sinew.skin.live


def test_a_failed_bake_leaves_nothing(waving):
    skin, rig = waving
    bpy.data.objects.remove(bpy.data.objects["Muscle lower"])
    before = points_over(skin, (1, 12))
    with pytest.raises(RuntimeError, match="muscles"):
        bake(skin)
    assert skin.data.shape_keys is None and skin.sinew.skin.live
    assert np.array_equal(points_over(skin, (1, 12)), before)


def test_a_cancelled_bake_leaves_nothing(waving):
    from bl_ext.user_default.sinew.bake.keys.shape_keys import Bake

    skin, _rig = waving
    bpy.context.scene.frame_set(5)
    before = points_over(skin, (5,))
    half = Bake([skin], bpy.context.scene, 1, 12, 1, "sinew_", 0.0)
    steps = half.steps()
    for _ in range(6):
        next(steps)
    half.cancel()
    assert skin.data.shape_keys is None and skin.sinew.skin.live and bpy.context.scene.frame_current == 5
    assert np.array_equal(points_over(skin, (5,)), before)


def test_a_key_of_the_user_with_that_name_does_not_change(waving):
    skin, _rig = waving
    skin.shape_key_add(name="Basis")
    skin.shape_key_add(name="sinew_0003")
    with pytest.raises(RuntimeError, match="another prefix"):
        bake(skin)
    assert len(skin.data.shape_keys.key_blocks) == 2


def test_a_bake_replaces_only_keys_with_its_prefix(waving):
    skin, _rig = waving
    select(skin)
    bpy.ops.sinew.bake_shape_keys(frame_start=3, frame_end=4, step=1, tolerance=0.0, prefix="walk_slow")
    bpy.ops.sinew.bake_shape_keys(frame_start=5, frame_end=6, step=1, tolerance=0.0, prefix="walk")
    names = [key.name for key in skin.data.shape_keys.key_blocks]
    assert names == ["Basis", "walk_slow0003", "walk_slow0004", "walk0005", "walk0006"]
    assert not any(baked.muted_by_sinew for baked in skin.sinew.skin.baked_keys)


def test_bakes_of_the_same_frames_do_not_add_up(waving):
    skin, _rig = waving
    live = points_over(skin, range(1, 13))
    select(skin)
    for prefix in ("first", "second"):
        bpy.ops.sinew.bake_shape_keys(frame_start=1, frame_end=12, step=1, tolerance=0.0, prefix=prefix)
    assert np.abs(points_over(skin, range(1, 13)) - live).max() < 1e-6
    assert skin.sinew.skin.bake_error_mm < 0.3  # between frames


def test_bakes_of_neighbouring_frames_both_play(waving):
    skin, _rig = waving
    live = points_over(skin, range(1, 13))
    select(skin)
    bpy.ops.sinew.bake_shape_keys(frame_start=1, frame_end=6, step=1, tolerance=0.0, prefix="first")
    bpy.ops.sinew.bake_shape_keys(frame_start=7, frame_end=12, step=1, tolerance=0.0, prefix="second")
    assert np.abs(points_over(skin, range(1, 13)) - live).max() < 1e-6


def test_a_cancelled_comparison_keeps_the_bake(waving):
    from bl_ext.user_default.sinew.bake.keys.shape_keys import Bake

    skin, _rig = waving
    live = points_over(skin, range(1, 13))
    stopped = Bake([skin], bpy.context.scene, 1, 12, 1, "sinew_", 0.0)
    steps = stopped.steps()
    while not stopped.is_baked:
        next(steps)
    stopped.cancel()
    assert not skin.sinew.skin.live and skin.sinew.skin.bake_error_mm == -1.0
    assert np.abs(points_over(skin, range(1, 13)) - live).max() < 1e-6


def halves_over(skin, first, last):
    points = []
    for half in range(2 * first, 2 * last + 1):
        bpy.context.scene.frame_set(half // 2, subframe=0.5 * (half % 2))
        points.append(evaluated_points(skin))
    return np.array(points)


def apart_mm(a, b):
    return 1000.0 * float(np.linalg.norm(a - b, axis=-1).max())


@pytest.mark.parametrize("tolerance", [0.5, 0.05])
def test_few_keys_stay_within_the_tolerance_at_frames_and_half_frames(waving, tolerance):
    skin, rig = waving
    rig.scale = (2.0, 2.0, 2.0)  # the tolerance is in world space
    live = halves_over(skin, 1, 12)
    bake(skin, tolerance=tolerance)
    found = apart_mm(2.0 * halves_over(skin, 1, 12), 2.0 * live)
    assert found < tolerance + 1e-3 and found < skin.sinew.skin.bake_error_mm + 1e-3
    assert 0.1 * tolerance < found  # the bake uses most of the tolerance
    assert len(skin.data.shape_keys.key_blocks) - 1 < len(live)


def test_a_smaller_tolerance_needs_more_keys(waving):
    skin, _rig = waving
    counts = []
    for tolerance in (2.0, 0.2, 0.02):
        bake(skin, tolerance=tolerance)
        counts.append(len(skin.data.shape_keys.key_blocks))
    assert counts == sorted(counts) and counts[0] < counts[-1]


def test_a_repeated_pose_has_one_key(waving):
    """A motion there and back: a frame and its mirror in time share one shape, and the rest pose has none."""
    skin, rig = waving
    bone = rig.pose.bones["lower"]
    for frame, angle in ((1, 0.0), (4, 1.0), (8, 1.0), (11, 0.0), (12, 0.0)):
        bone.rotation_euler[2] = angle
        bone.keyframe_insert("rotation_euler", frame=frame)
    live = points_over(skin, range(1, 13))
    bake(skin)
    assert [key.name for key in skin.data.shape_keys.key_blocks[1:]] == ["sinew_0002", "sinew_0003", "sinew_0004"]
    assert np.abs(points_over(skin, range(1, 13)) - live).max() < 1e-6


def test_a_bake_has_the_normals_of_live(waving):
    """Compares normals of the evaluated mesh where the keys cross-fade."""
    skin, _rig = waving
    skin.data.shade_smooth()

    def normals(frame):
        bpy.context.scene.frame_set(frame)
        mesh = skin.evaluated_get(bpy.context.evaluated_depsgraph_get()).data
        found = np.empty(3 * len(mesh.vertices), np.float32)
        mesh.vertex_normals.foreach_get("vector", found)
        return found.reshape(-1, 3)

    live = [normals(frame) for frame in range(1, 13)]
    bake(skin, tolerance=0.1)
    cosines = [np.einsum("vc,vc->v", a, normals(frame)) for frame, a in enumerate(live, 1)]
    assert np.degrees(np.arccos(np.clip(min(map(np.min, cosines)), -1.0, 1.0))) < 1.0


def test_other_animation_of_keys_does_not_change(waving):
    skin, _rig = waving
    skin.shape_key_add(name="Basis")
    own = skin.shape_key_add(name="Smile")
    for frame, value in ((1, 0.0), (12, 1.0)):
        own.value = value
        own.keyframe_insert("value", frame=frame)
    before = own.id_data.animation_data.action
    bake(skin)
    bake(skin, frame_end=6)
    bpy.context.scene.frame_set(12)
    assert own.id_data.animation_data.action == before and own.value == 1.0
