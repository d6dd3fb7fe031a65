"""The laws of the core, tested through the binding against numpy."""

import threading

import _sinew
import numpy as np
import pytest
from conftest import REST, column_major, make_limb, rotation, translation
from hypothesis import given, settings
from hypothesis import strategies as st

LIMB = make_limb()
ANGLES = st.floats(-1.4, 1.4)
WAYS = [
    (skinning, motion_source) for skinning in ("LINEAR", "PRESERVE_VOLUME", "NONE") for motion_source in ("SWELLING", "FULL")
]


def row_major(pose):
    return np.swapaxes(pose.astype(np.float64), 1, 2)


def linear_skinning(points, pose):
    """`Σ w B x / Σ w` in numpy."""
    palette = row_major(pose) @ np.linalg.inv(row_major(LIMB.rest))
    carried = np.einsum("bij,vj->vbi", palette, np.c_[points.astype(np.float64), np.ones(len(points))])[..., :3]
    weights = LIMB.mesh["weights"].reshape(-1, 2).astype(np.float64)
    return np.einsum("vbi,vb->vi", carried, weights / weights.sum(axis=1, keepdims=True))


def deformed(skin, pose, tension=None):
    out = LIMB.out()
    skin.deform(pose, LIMB.relaxed if tension is None else tension, out)
    return out


def corrected(skin, pose, tension=None):
    out = LIMB.out()
    return out, skin.correct(pose, LIMB.relaxed if tension is None else tension, out)


@pytest.mark.parametrize(("skinning", "motion_source"), WAYS)
@pytest.mark.parametrize("scale_fat", [False, True])
@pytest.mark.parametrize("anchoring", ["BLENDED", "NEAREST"])
def test_the_rest_pose_moves_no_vertex(skinning, motion_source, scale_fat, anchoring):
    skin = LIMB.skin(skinning=skinning, motion_source=motion_source, scale_fat=scale_fat, anchoring=anchoring)
    offsets, report = corrected(skin, LIMB.rest)
    assert abs(offsets).max() <= 1e-6 and report.damped == 0 and report.clamped == []
    assert abs(deformed(skin, LIMB.rest) - LIMB.mesh["points"]).max() <= 1e-6


@given(angle=st.floats(-3, 3), shift=st.tuples(*[st.floats(-2, 2)] * 3))
def test_linear_skinning_equals_numpy(angle, shift):
    pose = LIMB.bent(angle, translation(shift))
    skin = LIMB.skin(gain=0.0)
    np.testing.assert_allclose(deformed(skin, pose), linear_skinning(LIMB.mesh["points"], pose), atol=2e-6)


@given(angle=ANGLES, tension=st.floats(0, 1, width=32))
def test_corrected_points_skinned_by_numpy_equal_deformed_points(angle, tension):
    skin = LIMB.skin(motion_source="FULL")
    tensions = np.array([tension, 0, 0], np.float32)
    offsets, report = corrected(skin, LIMB.bent(angle), tensions)
    got = linear_skinning(LIMB.mesh["points"].astype(np.float64) + offsets, LIMB.bent(angle))
    assert report.damped == 0
    np.testing.assert_allclose(got, deformed(skin, LIMB.bent(angle), tensions), atol=3e-6)


@given(angle=st.floats(-3, 3), tension=st.floats(0, 1, width=32), shift=st.tuples(*[st.floats(-1, 1)] * 3))
def test_a_belly_keeps_its_volume(angle, tension, shift):
    out = np.empty((3, 4, 4), np.float32)
    pose = LIMB.bent(angle)
    pose[1, 3, :3] += np.array(shift, np.float32)
    posed = LIMB.musculature.pose(pose, np.array([tension, 0, 0], np.float32), out)
    assert posed.volume[0] == pytest.approx(LIMB.tissues[0].volume, rel=1e-6)
    axes = np.linalg.norm(out[0, :3, :3], axis=1)
    assert 4 / 3 * np.pi * axes.prod() == pytest.approx(LIMB.tissues[0].volume, rel=1e-5)
    assert axes[0] / axes[1] == pytest.approx(0.02 / 0.025, rel=1e-5)
    assert axes[2] / 0.1 == pytest.approx(posed.stretch[0], rel=1e-5)


@settings(max_examples=25)
@given(angle=ANGLES, turn=st.floats(-3, 3), shift=st.tuples(*[st.floats(-3, 3)] * 3), way=st.sampled_from(WAYS[:4]))
def test_a_moved_rig_moves_its_skin(angle, turn, shift, way):
    skin = LIMB.skin(skinning=way[0], motion_source=way[1])
    motion = translation(shift) @ rotation((1, 2, -1), turn)
    here = deformed(skin, LIMB.bent(angle)).astype(np.float64)
    there = deformed(skin, LIMB.bent(angle, motion))
    np.testing.assert_allclose(here @ motion[:3, :3].T + motion[:3, 3], there, atol=1e-5)


def test_posed_matrices_at_rest_are_those_of_the_tissues():
    out = np.empty((3, 4, 4), np.float32)
    posed = LIMB.musculature.pose(LIMB.rest, LIMB.relaxed, out)
    np.testing.assert_allclose(out[0].T, [[0.02, 0, 0, 0.03], [0, 0.025, 0, 0], [0, 0, 0.1, 0.3], [0, 0, 0, 1]], atol=1e-7)
    np.testing.assert_allclose(out[1].T, np.diag([0.02, 0.02, 0.15, 1]) + translation((0, 0, 0.15)) - np.eye(4), atol=1e-7)
    np.testing.assert_allclose(posed.stretch, 1)


def test_a_crushed_muscle_is_clamped_and_named():
    pose = LIMB.rest
    pose[1, 3, :3] -= (0, 0, 0.22)
    posed = LIMB.musculature.pose(pose, LIMB.relaxed, np.empty((3, 4, 4), np.float32))
    assert posed.clamped == ["flexor"] and 0.1 <= posed.stretch[0] < 0.2
    assert corrected(LIMB.skin(), pose)[1].clamped == ["flexor"]


def test_a_bone_scaled_away_is_damped_and_bounded():
    pose = column_major(REST @ np.diag([1, 1e-5, 1, 1]))
    tension = np.array([1, 0, 0], np.float32)
    offsets, report = corrected(LIMB.skin(), pose, tension)
    assert report.damped > 0 and np.isfinite(offsets).all() and abs(offsets).max() < 1


def test_influences():
    blended, nearest = LIMB.skin().tissue_weights, LIMB.skin(anchoring="NEAREST").tissue_weights
    assert blended.shape == (len(LIMB.mesh["points"]), 3) and blended.dtype == np.float32
    assert (blended >= 0).all() and (blended.sum(axis=1) <= 1 + 1e-5).all()
    assert ((nearest > 0).sum(axis=1) <= 1).all()
    skin = LIMB.skin(anchoring="NEAREST", motion_source="FULL")
    assert skin.anchored == (skin.tissue_weights.sum(axis=1) > 0).sum() > 0
    still, _ = corrected(skin, LIMB.bent(1.0))
    free = skin.tissue_weights.sum(axis=1) == 0
    assert free.any() and (still[free] == 0).all()


def test_muscle_influence_scales_the_swelling():
    tension = np.array([1, 0, 0], np.float32)
    one, two = (corrected(LIMB.skin(gain=gain), LIMB.bent(0.8), tension)[0] for gain in (1.0, 2.0))
    assert abs(one).max() > 1e-3
    np.testing.assert_allclose(2 * one, two, atol=1e-6)


def test_any_number_of_threads_gives_the_same_bits():
    big = make_limb(64, 64)
    frames = []
    try:
        for count in (1, 2, 8, 0):
            _sinew.set_thread_count(count)
            for motion_source in ("SWELLING", "FULL"):
                skin = big.skin(motion_source=motion_source, skinning="PRESERVE_VOLUME")
                out = np.empty((64 * 64, 3), np.float32)
                skin.correct(big.bent(1.1), big.relaxed, out)
                frames.append(out.tobytes() + skin.tissue_weights.tobytes())
    finally:
        _sinew.set_thread_count(0)
    assert len(set(frames[0::2])) == len(set(frames[1::2])) == 1
    assert frames[0] != frames[1]


@given(points=st.lists(st.tuples(*[st.floats(-10, 10)] * 3), max_size=20))
def test_nearest_points_lie_on_the_ellipsoid_and_are_nearest(points):
    points = np.array(points, np.float64).reshape(-1, 3)
    semi_axes = np.array([0.5, 2.0, 1.0])
    nearest = _sinew.nearest_on_ellipsoid(semi_axes, points)
    assert nearest.shape == points.shape and nearest.dtype == np.float64
    np.testing.assert_allclose(((nearest / semi_axes) ** 2).sum(axis=1), 1, atol=1e-9)
    rivals = np.random.default_rng(0).normal(size=(2000, 3))
    rivals = rivals / np.linalg.norm(rivals, axis=1, keepdims=True) * semi_axes
    own = np.linalg.norm(nearest - points, axis=1)
    others = np.linalg.norm(rivals[None] - points[:, None], axis=2)
    assert (own <= others.min(axis=1, initial=np.inf) + 1e-9).all()


def test_nearest_of_the_centre_is_the_end_of_the_shortest_axis():
    nearest = _sinew.nearest_on_ellipsoid((0.5, 2.0, 1.0), np.zeros((1, 3)))
    np.testing.assert_array_equal(abs(nearest), [[0.5, 0, 0]])


@pytest.mark.parametrize("semi_axes", [(0, 1, 1), (1, -1, 1), (1, 1), (1, 1, float("nan")), None])
def test_semi_axes_of_0_are_refused(semi_axes):
    with pytest.raises(ValueError, match="semi_axes"):
        _sinew.nearest_on_ellipsoid(semi_axes, np.zeros((1, 3)))


def test_python_runs_while_a_skin_is_bound():
    """The worker releases the GIL, so this thread counts while it binds."""
    big = make_limb(200, 1000)
    finished = threading.Event()

    def bind():
        big.skin(motion_source="FULL", falloff=10.0)
        finished.set()

    worker = threading.Thread(target=bind)
    interval = _switch_interval(1000.0)  # no thread is asked to release the GIL
    try:
        worker.start()
        ticks = 0
        while not finished.is_set():
            ticks += 1
            finished.wait(0.0005)
        worker.join()
    finally:
        _switch_interval(interval)
    assert ticks > 3


def _switch_interval(seconds):
    import sys

    before = sys.getswitchinterval()
    sys.setswitchinterval(seconds)
    return before


def test_one_skin_computes_frames_in_many_threads():
    skin = LIMB.skin()
    due = [deformed(skin, LIMB.bent(0.2 * frame)) for frame in range(6)]
    wrong = []

    def work(frame):
        for _ in range(30):
            if not np.array_equal(deformed(skin, LIMB.bent(0.2 * frame)), due[frame]):
                wrong.append(frame)

    workers = [threading.Thread(target=work, args=(frame,)) for frame in range(6)]
    for worker in workers:
        worker.start()
    for worker in workers:
        worker.join()
    assert wrong == []
