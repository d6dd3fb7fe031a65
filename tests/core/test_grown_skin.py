"""A grown skin through the binding."""

import threading
import time

import _sinew
import numpy as np
import pytest


def grown(limb, **changes):
    bones = len(limb.skeleton)
    arguments = {
        "skin_thickness": np.zeros(len(limb.tissues), np.float32),
        "bone_lengths": np.full(bones, 0.3, np.float32),
        "weight_bones": np.arange(bones, dtype=np.int32),
    }
    return _sinew.GrownSkin(limb.musculature, **arguments | changes)


def test_the_arrays_of_a_grown_skin_make_a_skin(limb):
    skin = grown(limb)
    count = len(skin)
    assert skin.points.shape == (count, 3) and skin.points.dtype == np.float32
    assert skin.quads.shape[1] == 4 and skin.quads.dtype == np.int32
    assert skin.quads.min() == 0 and skin.quads.max() == count - 1
    assert skin.weight_offsets[0] == 0 and skin.weight_offsets[-1] == len(skin.weights) == len(skin.weight_bones)
    np.testing.assert_allclose(np.add.reduceat(skin.weights, skin.weight_offsets[:-1]), 1.0, atol=1e-5)
    sides = np.concatenate([skin.quads[:, [corner, (corner + 1) % 4]] for corner in range(4)])
    assert len(np.unique(sides, axis=0)) == len(sides)
    assert np.array_equal(np.unique(sides, axis=0), np.unique(sides[:, ::-1], axis=0))
    assert skin.worst_quality >= 0.1 and skin.pieces == 1 and 0.0 <= skin.protrusion <= skin.voxel
    bound = _sinew.Skin(
        limb.musculature,
        skin.points,
        np.ascontiguousarray(sides),
        np.eye(4, dtype=np.float32),
        skin.weight_offsets,
        skin.weight_bones,
        skin.weights,
    )
    assert bound.anchored > 0


def test_replacement_bones_take_the_weights(limb):
    assert set(grown(limb).weight_bones) == {0, 1}
    assert set(grown(limb, weight_bones=np.zeros(2, np.int32)).weight_bones) == {0}


def test_thickness_overall_and_by_tissue(limb):
    thin = np.ptp(grown(limb).points, axis=0)
    thick = np.ptp(grown(limb, thickness=0.02).points, axis=0)
    np.testing.assert_allclose(thick - thin, 0.04, atol=0.004)
    one = grown(limb, skin_thickness=np.array([0.0, 0.05, 0.0], np.float32))
    assert np.ptp(one.points[:, 1]) > thin[1] + 0.05


def test_growing_twice_gives_the_same_skin(limb):
    first, second = grown(limb, faces=500), grown(limb, faces=500)
    assert np.array_equal(first.points, second.points) and np.array_equal(first.quads, second.quads)
    assert 300 < len(first.quads) <= 500


def test_growing_reports_progress_and_can_be_cancelled(limb):
    progress = _sinew.Progress()
    assert progress.done == 0.0
    grown(limb, progress=progress)
    assert progress.done == 1.0
    progress = _sinew.Progress()
    problems = []

    def work():
        try:
            grown(limb, resolution=1500, memory_limit_mb=8000.0, progress=progress)
        except _sinew.SinewError as error:
            problems.append(str(error))

    thread = threading.Thread(target=work)
    thread.start()
    time.sleep(0.05)
    progress.cancel()
    thread.join(30.0)
    assert not thread.is_alive() and problems == ["Cancelled; nothing has changed"]


@pytest.mark.parametrize(
    ("changes", "error", "message"),
    [
        ({"resolution": 2}, _sinew.SinewError, "resolution .* is 2, must be 4 to 8192"),
        ({"thickness": float("nan")}, ValueError, "thickness"),
        ({"faces": 10}, _sinew.SinewError, "number of faces is 10, must be 50 or more"),
        (
            {"resolution": 4000, "memory_limit_mb": 50.0},
            _sinew.SinewError,
            r"needs about \d+ MB of memory, the limit is 50 MB",
        ),
        ({"skin_thickness": np.zeros(2, np.float32)}, ValueError, "skin_thickness: expected float32 array of shape"),
        ({"skin_thickness": np.full(3, -1, np.float32)}, _sinew.SinewError, "flexor.*thickness of the skin over it"),
        ({"bone_lengths": np.zeros(2)}, ValueError, "bone_lengths: expected float32"),
        ({"weight_bones": np.array([0, 2], np.int32)}, ValueError, "weight_bones: entry 1 is 2, outside 0..2"),
        ({"weight_bones": np.array([0, -1], np.int32)}, ValueError, "weight_bones: entry 1 is -1, outside 0..2"),
    ],
)
def test_impossible_values_are_refused(limb, changes, error, message):
    with pytest.raises(error, match=message):
        grown(limb, **changes)
