"""Linear blend skinning through the binding: added offsets reach their target, and bad arguments are refused."""

import _sinew
import numpy as np
import pytest


@pytest.fixture
def linear(limb):
    mesh = {name: value for name, value in limb.mesh.items() if name != "edges"}
    return _sinew.LinearSkin(limb.skeleton, **mesh)


def test_added_offsets_reach_the_target(limb, linear):
    pose, (target, added, got) = limb.bent(0.9), (limb.out(), limb.out(), limb.out())
    limb.skin().deform(pose, limb.relaxed, target)
    assert linear.correct(pose, target, added) == 0
    linear.deform(pose, added, got)
    assert np.abs(got - target).max() < 1e-6


def test_fitted_weights_are_positive_with_a_sum_of_one(limb, linear):
    poses = np.array([limb.bent(angle) for angle in (0.3, 0.9)])
    targets = np.array([limb.out(), limb.out()])
    for pose, target in zip(poses, targets, strict=True):
        limb.skin().deform(pose, limb.relaxed, target)
    offsets, bones, weights = linear.fit(poses, targets, 1, 0.001)
    assert offsets.dtype == bones.dtype == np.int32 and weights.dtype == np.float32
    assert len(offsets) == len(linear) + 1 and np.diff(offsets).max() == 1
    assert np.allclose(weights, 1.0)


@pytest.mark.parametrize(("most", "hold", "message"), [(0, 0.0, "most"), (4, -1.0, "hold"), (4, np.nan, "hold")])
def test_impossible_limits_are_refused(limb, linear, most, hold, message):
    with pytest.raises(ValueError, match=message):
        linear.fit(np.array([limb.rest]), np.array([limb.out()]), most, hold)


def test_arrays_that_do_not_fit_are_refused_by_name(limb, linear):
    rest, out = limb.rest, limb.out()
    with pytest.raises(ValueError, match="offsets"):
        linear.deform(rest, out[:-1], out)
    with pytest.raises(ValueError, match="pose"):
        linear.correct(rest[:-1], out, limb.out())
    with pytest.raises(ValueError, match="out"):
        linear.correct(rest, out, out)
    with pytest.raises(ValueError, match="targets"):
        linear.fit(np.array([rest, rest]), np.array([out]), 4, 0.0)
