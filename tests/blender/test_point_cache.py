# SPDX-License-Identifier: GPL-3.0-or-later
"""Point caches: Blender's Mesh Cache modifier plays the live points, and a file is complete or absent."""

import os
import struct

import bpy
import numpy as np
import pytest
from bl_ext.user_default.sinew.bake.cache import point_cache
from bl_ext.user_default.sinew.bake.cache.cache_bake import CacheBake, CacheSettings
from bl_ext.user_default.sinew.errors import SinewError
from bl_ext.user_default.sinew.files import atomic_write
from bl_ext.user_default.sinew.files.file_names import LONGEST_STEM_BYTES, stem_of
from conftest import (
    add_muscle,
    bend,
    bind,
    evaluated_points,
    link_character,
    make_arm,
    points_over,
    save_character,
    select,
    snapshot,
)
from hypothesis import given
from hypothesis import strategies as st

FRAMES = range(1, 13)


def bake(skin, to, **settings):
    select(skin)
    return bpy.ops.sinew.bake_cache(**{"frame_start": 1, "frame_end": 12, "step": 1, "folder": str(to)} | settings)


def add_smile(skin):
    """Adds a keyed shape key to a mesh."""
    skin.shape_key_add(name="Basis")
    own = skin.shape_key_add(name="Smile")
    for point in own.points:
        point.co.z += 0.01
    for frame, own.value in ((1, 0.0), (12, 1.0)):
        own.keyframe_insert("value", frame=frame)


def objects_and_modifiers(skin):
    return sorted(bpy.data.objects.keys()), [modifier.name for modifier in skin.modifiers], skin.sinew.skin.live


@pytest.mark.parametrize("up_axis", ["Z", "Y"])
@pytest.mark.parametrize("file_format", ["PC2", "MDD"])
@pytest.mark.parametrize("points", ["BEFORE_ARMATURE", "POSED"])
def test_the_mesh_cache_modifier_plays_as_live(waving, tmp_path, points, file_format, up_axis):
    skin, _rig = waving
    live = points_over(skin, FRAMES)
    assert bake(skin, tmp_path, points=points, file_format=file_format, up_axis=up_axis) == {"FINISHED"}
    assert not skin.sinew.skin.live and [found.type for found in bpy.data.objects].count("MESH") == 1
    assert np.array_equal(points_over(skin, FRAMES), live)
    assert [path.name for path in tmp_path.iterdir()] == [f"Arm.{file_format.lower()}"]
    skin.sinew.skin.live = True
    assert np.array_equal(points_over(skin, FRAMES), live)


def test_the_cache_plays_without_sinew(waving, tmp_path):
    import addon_utils

    skin, _rig = waving
    live = points_over(skin, FRAMES)
    bake(skin, tmp_path)
    addon_utils.disable("bl_ext.user_default.sinew")
    assert np.array_equal(points_over(skin, FRAMES), live)


def test_posed_points_are_the_displayed_points(waving, tmp_path):
    skin, _rig = waving
    live = points_over(skin, FRAMES)
    bake(skin, tmp_path, points="POSED", attach=False)
    cache = point_cache.read(tmp_path / "Arm.pc2", "PC2")
    assert (cache.frame_start, cache.step) == (1.0, 1.0) and np.array_equal(cache.samples, live)
    assert skin.sinew.skin.live and "Sinew Cache" not in skin.modifiers


def test_the_header_of_pc2_is_as_specified(waving, tmp_path):
    skin, _rig = waving
    bake(skin, tmp_path, frame_start=-4, frame_end=12, step=4, attach=False)
    head = (tmp_path / "Arm.pc2").read_bytes()[:32]
    assert struct.unpack("<12siiffi", head) == (b"POINTCACHE2\0", 1, 480, -4.0, 4.0, 5)


def test_the_header_of_mdd_is_as_specified(waving, tmp_path):
    skin, _rig = waving
    bake(skin, tmp_path, frame_end=9, step=4, attach=False, file_format="MDD")
    head = (tmp_path / "Arm.mdd").read_bytes()[:20]
    assert struct.unpack(">ii3f", head) == pytest.approx((3, 480, 0.0, 4 / 24, 8 / 24))


def test_every_fourth_frame_plays_at_its_frames(waving, tmp_path):
    skin, _rig = waving
    live = points_over(skin, (2, 6, 10))
    bake(skin, tmp_path, frame_start=2, frame_end=11, step=4)
    assert np.abs(points_over(skin, (2, 6, 10)) - live).max() < 1e-6


def test_the_rig_still_poses_a_cache_before_the_armature(waving, tmp_path):
    skin, rig = waving
    bake(skin, tmp_path, frame_end=1)
    flat = points_over(skin, (1,))[0]
    rig.animation_data_clear()
    bend(rig, 1.2)
    assert np.abs(evaluated_points(skin) - flat).max() > 0.1


def test_shape_keys_and_later_modifiers_are_kept(waving, tmp_path):
    skin, _rig = waving
    add_smile(skin)
    skin.modifiers.new("Subdivision", "SUBSURF").levels = 1
    live = points_over(skin, FRAMES)
    for points in ("BEFORE_ARMATURE", "POSED"):
        bake(skin, tmp_path, points=points)
        assert len(live[0]) > 1000 and np.abs(points_over(skin, FRAMES) - live).max() < 1e-6
        assert len(skin.modifiers) == 4


def test_an_earlier_modifier_that_adds_vertices_is_refused(waving, tmp_path):
    skin, _rig = waving
    skin.modifiers.new("Twice", "ARRAY")
    skin.modifiers.move(skin.modifiers.find("Twice"), 0)
    before = objects_and_modifiers(skin)
    with pytest.raises(RuntimeError, match="changes the number of vertices"):
        bake(skin, tmp_path)
    assert objects_and_modifiers(skin) == before and not list(tmp_path.iterdir())


def test_two_skins_are_two_files(waving, tmp_path):
    skin, rig = waving
    other, other_rig = make_arm("Sleeve", rings=12, radius=0.06)
    other.modifiers["Armature"].object = other.parent = rig
    bpy.data.objects.remove(other_rig)
    bind(other)
    live = points_over(skin, FRAMES), points_over(other, FRAMES)
    select(rig)
    bpy.ops.sinew.bake_cache(frame_start=1, frame_end=12, folder=str(tmp_path))
    assert sorted(path.name for path in tmp_path.iterdir()) == ["Arm.pc2", "Sleeve.pc2"]
    for found, points in zip((skin, other), live):
        assert not found.sinew.skin.live and np.array_equal(points_over(found, FRAMES), points)


def test_a_linked_and_overridden_character(waving, tmp_path):
    save_character(str(tmp_path / "character.blend"))
    skin, _rig = link_character(str(tmp_path / "character.blend"))
    live = points_over(skin, FRAMES)
    for points in ("BEFORE_ARMATURE", "POSED"):
        bake(skin, tmp_path, points=points)
        assert np.array_equal(points_over(skin, FRAMES), live)
    assert np.ptp(live, axis=0).max() > 0.1
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "shot.blend"))
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "shot.blend"))
    skin = bpy.data.objects["Arm", None]
    assert np.array_equal(points_over(skin, FRAMES), live)
    skin.sinew.skin.live = True
    assert not skin.modifiers["Sinew Cache"].show_viewport and np.array_equal(points_over(skin, FRAMES), live)


def test_undo_removes_the_playback(waving, tmp_path):
    skin, _rig = waving
    bpy.ops.ed.undo_push(message="before")
    bake(skin, tmp_path)
    bpy.ops.ed.undo_push(message="baked")
    bpy.ops.ed.undo()
    skin = bpy.data.objects["Arm"]
    assert skin.sinew.skin.live and [modifier.name for modifier in skin.modifiers] == ["Sinew", "Armature"]


@pytest.mark.parametrize("points", ["BEFORE_ARMATURE", "POSED"])
def test_a_new_cache_replaces_the_old(waving, tmp_path, points):
    skin, _rig = waving
    live = points_over(skin, FRAMES)
    bake(skin, tmp_path)
    skin.modifiers["Sinew Cache"].name = "Renamed"
    bake(skin, tmp_path, points=points)
    assert sum(modifier.type == "MESH_CACHE" for modifier in skin.modifiers) == 1
    assert np.array_equal(points_over(skin, FRAMES), live)


def test_shape_keys_that_a_cache_would_hide_are_refused(waving, tmp_path):
    skin, _rig = waving
    bake(skin, tmp_path)
    with pytest.raises(RuntimeError, match="plays a point cache"):
        bpy.ops.sinew.bake_shape_keys(frame_start=1, frame_end=3)
    skin.modifiers.remove(skin.modifiers["Sinew Cache"])
    assert bpy.ops.sinew.bake_shape_keys(frame_start=1, frame_end=3) == {"FINISHED"}


def test_a_cancelled_bake_leaves_nothing_and_keeps_the_old_file(waving, tmp_path):
    skin, _rig = waving
    bake(skin, tmp_path, attach=False)
    old = (tmp_path / "Arm.pc2").read_bytes()
    bpy.context.scene.frame_set(5)
    before = objects_and_modifiers(skin), evaluated_points(skin).tobytes()
    half = CacheBake([skin], bpy.context.scene, range(1, 9), CacheSettings("POSED", "PC2", "Z"), [tmp_path / "Arm.pc2"])
    steps = half.steps()
    for _ in range(4):
        next(steps)
    assert len(list(tmp_path.iterdir())) == 2
    steps.close()
    assert [path.read_bytes() for path in tmp_path.iterdir()] == [old]
    assert bpy.context.scene.frame_current == 5
    assert (objects_and_modifiers(skin), evaluated_points(skin).tobytes()) == before


def test_a_failed_bake_leaves_nothing(waving, tmp_path):
    skin, _rig = waving
    bpy.data.objects.remove(bpy.data.objects["Muscle lower"])
    bpy.context.view_layer.update()
    before = objects_and_modifiers(skin)
    with pytest.raises(RuntimeError, match="muscles"):
        bake(skin, tmp_path)
    assert objects_and_modifiers(skin) == before and not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("settings", "words"),
    [({"frame_start": 9, "frame_end": 3}, "before the first"), ({"folder": "//"}, "not saved")],
)
def test_impossible_bakes_are_refused(waving, tmp_path, settings, words):
    skin, _rig = waving
    with pytest.raises(RuntimeError, match=words):
        bake(skin, tmp_path, **settings)
    assert skin.sinew.skin.live and not list(tmp_path.iterdir())


def test_a_file_with_the_folders_name_is_reported(waving, tmp_path):
    skin, _rig = waving
    (tmp_path / "taken").write_text("a person's")
    with pytest.raises(RuntimeError, match="could not be made"):
        bake(skin, tmp_path / "taken" / "below")
    (tmp_path / "Arm.pc2").mkdir()
    with pytest.raises(RuntimeError, match="is a folder"):
        bake(skin, tmp_path)
    assert (tmp_path / "taken").read_text() == "a person's" and skin.sinew.skin.live


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="limits of file sizes are POSIX")
def test_a_full_disk_is_reported_and_the_old_file_stays(waving, tmp_path):
    """A limit of the file size simulates a full disk: the write fails halfway, and leaves nothing."""
    import resource
    import signal

    skin, _rig = waving
    bake(skin, tmp_path, attach=False)
    old = (tmp_path / "Arm.pc2").read_bytes()
    previous = signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (len(old) // 2, hard))
    try:
        with pytest.raises(RuntimeError, match="could not be written .*; an existing file there is unchanged"):
            bake(skin, tmp_path, points="POSED")
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))
        signal.signal(signal.SIGXFSZ, previous)
    assert [path.read_bytes() for path in tmp_path.iterdir()] == [old]
    assert skin.sinew.skin.live and "Sinew Cache" not in skin.modifiers


def test_remove_leaves_no_trace_but_the_file(arm, tmp_path):
    skin, rig = arm
    before = snapshot(skin, rig)
    add_muscle(rig)
    bind(skin)
    bake(skin, tmp_path)
    select(rig)
    bpy.ops.sinew.remove()
    assert snapshot(skin, rig) == before and (tmp_path / "Arm.pc2").is_file()


def test_remove_can_keep_the_cache(waving, tmp_path):
    skin, rig = waving
    live = points_over(skin, FRAMES)
    bake(skin, tmp_path)
    skin.sinew.skin.live = True
    select(rig)
    bpy.ops.sinew.remove(keep_baked=True)
    assert [modifier.name for modifier in skin.modifiers] == ["Sinew Cache", "Armature"]
    assert np.array_equal(points_over(skin, FRAMES), live)


def test_the_cache_plays_after_the_file_moved_with_it(waving, tmp_path):
    skin, _rig = waving
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "arm.blend"))
    live = points_over(skin, FRAMES)
    bake(skin, "//cache")
    assert skin.modifiers["Sinew Cache"].filepath == "//cache/Arm.pc2"
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "arm.blend"))
    (tmp_path / "moved").mkdir()
    for name in ("arm.blend", "cache"):
        (tmp_path / name).rename(tmp_path / "moved" / name)
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "moved" / "arm.blend"))
    assert np.array_equal(points_over(bpy.data.objects["Arm"], FRAMES), live)


def test_unfinished_files_are_removed_if_their_process_has_ended(tmp_path):
    import subprocess
    import sys

    ended = subprocess.Popen([sys.executable, "-c", ""])
    ended.wait()
    mark = f"{atomic_write._machine()}.{{}}.01234567.sinew-part.pc2"
    dead, living, other, elsewhere = (
        tmp_path / name
        for name in (
            ".Arm." + mark.format(ended.pid),
            ".Arm." + mark.format(os.getppid()),
            ".Leg." + mark.format(ended.pid),
            f".Arm.elsewhere.{ended.pid}.01234567.sinew-part.pc2",
        )
    )
    for path in (dead, living, other, elsewhere):
        path.write_text("half")
    with atomic_write.atomic_write(tmp_path / "Arm.pc2") as file:
        file.write(b"whole")
    assert not dead.exists() and living.exists() and other.exists() and elsewhere.exists()
    os.utime(elsewhere, (0, 0))
    with atomic_write.atomic_write(tmp_path / "Arm.pc2") as file:
        file.write(b"again")
    assert not elsewhere.exists() and (tmp_path / "Arm.pc2").read_bytes() == b"again"


def test_an_error_in_the_block_leaves_the_old_file(tmp_path):
    (tmp_path / "a.json").write_text("old")
    with pytest.raises(ZeroDivisionError), atomic_write.atomic_write(tmp_path / "a.json") as file:
        file.write(b"new")
        raise ZeroDivisionError
    assert [(path.name, path.read_text()) for path in tmp_path.iterdir()] == [("a.json", "old")]


@pytest.mark.parametrize("file_format", ["PC2", "MDD"])
def test_a_file_that_is_not_a_cache_is_refused(tmp_path, file_format):
    timing = point_cache.Timing(range(1, 4), 24.0)
    whole = point_cache.header_of(file_format, timing, 2) + bytes(3 * 2 * 12)
    path = tmp_path / "a.cache"
    for content in (b"", b"POINTCACHE1\0" + bytes(30), whole[:-1], whole + b"x", bytes(40)):
        path.write_bytes(content)
        with pytest.raises(SinewError):
            point_cache.read(path, file_format)
    path.write_bytes(whole)
    assert point_cache.read(path, file_format).samples.shape == (3, 2, 3)


@given(st.text(min_size=1), st.text(min_size=1))
def test_file_names_are_safe_and_unique(name, other):
    stem = stem_of(name)
    assert not set(stem) & set('/\\:*?"<>|\0') and not stem.startswith(".") and len(stem.encode()) <= LONGEST_STEM_BYTES
    assert stem.isprintable() and stem.upper() not in ("CON", "NUL", "COM1")
    if stem_of(other) == stem:
        import unicodedata

        assert unicodedata.normalize("NFC", name) == unicodedata.normalize("NFC", other)


def test_file_names_keep_allowed_characters():
    assert stem_of("Body.001") == "Body.001" and stem_of("Körper 体") == "Körper 体"
    assert stem_of("a/b") == "a%2Fb" != stem_of("a_b") and stem_of("..") == "%2E."
    assert stem_of("con") == "%63on" and stem_of("50%") == "50%25"
