"""Bakes through the binding: errors are those of the skin posed by the Armature modifier, and bad arrays are refused."""

import _sinew
import numpy as np
import pytest

ANGLES = np.linspace(0.0, 2.4, 25)


@pytest.fixture(scope="session")
def bend(limb):
    """(skin, poses, corrections) of a joint that bends from rest."""
    skin = limb.skin()
    poses, corrections = np.array([limb.bent(angle) for angle in ANGLES]), []
    for pose in poses:
        out = limb.out()
        skin.correct(pose, limb.relaxed, out)
        corrections.append(out)
    return skin, poses, np.array(corrections)


def skinned(limb, pose, offsets):
    """Linear blend skinning of the rest points plus offsets, in plain numpy."""
    carries = np.swapaxes(pose, 1, 2).astype(float) @ np.linalg.inv(np.swapaxes(limb.rest, 1, 2).astype(float))
    weights = np.zeros((len(offsets), len(pose)))
    vertices = np.repeat(np.arange(len(offsets)), np.diff(limb.mesh["weight_offsets"]))
    weights[vertices, limb.mesh["weight_bones"]] = limb.mesh["weights"]
    weights /= weights.sum(axis=1, keepdims=True)
    to_armature = limb.mesh["mesh_to_armature"].T.astype(float)
    points = np.c_[limb.mesh["points"].astype(float) + offsets, np.ones(len(offsets))] @ to_armature.T
    posed = np.einsum("vb,bij,vj->vi", weights, carries, points)
    return (posed @ np.linalg.inv(to_armature).T)[:, :3]


def test_errors_are_measured_on_the_posed_skin(limb, bend):
    skin, poses, corrections = bend
    keys = _sinew.MotionKeys(skin, poses, corrections, ANGLES, 5e-4, 0.0)
    assert 1 < len(keys) < len(ANGLES) - 1
    at, shapes = [0.0, *keys.at], [np.zeros_like(corrections[0]), *map(keys.correction, range(len(keys)))]
    worst = 0.0
    for angle, pose, correction in zip(ANGLES, poses, corrections, strict=True):
        tents = [np.interp(angle, at, np.eye(len(at))[key]) for key in range(len(at))]
        shown = sum(tent * shape for tent, shape in zip(tents, shapes, strict=True))
        difference = skinned(limb, pose, correction) - skinned(limb, pose, shown)
        worst = max(worst, np.linalg.norm(difference, axis=1).max())
    assert worst == pytest.approx(max(keys.error_at, keys.error_between), rel=1e-3, abs=1e-7)
    assert worst <= 5e-4 and keys.error_at == 0.0


def test_a_larger_tolerance_keeps_fewer_frames(bend):
    skin, poses, corrections = bend
    candidates = np.ones(len(ANGLES), bool)
    counts = []
    for tolerance in (1e-5, 1e-4, 1e-3):
        found = _sinew.KeptSamples(skin, poses, corrections, ANGLES, np.full(len(ANGLES), tolerance), candidates)
        assert found.errors.max() <= tolerance and found.shown[0] is None
        counts.append(len(found.places))
    assert counts[0] > counts[1] > counts[2] > 1


def test_keys_of_two_joint_turns_have_the_shape_of_the_mesh(limb, bend):
    skin, poses, corrections = bend
    keys = _sinew.MotionKeys(skin, poses, corrections, ANGLES, 1e-3, 0.0)
    values = ANGLES[[6, 12, 18, 24]]
    twice = np.ascontiguousarray(np.broadcast_to(corrections[-1], (4, 4, *corrections[0].shape)))
    grid = np.ascontiguousarray(np.broadcast_to(poses[-1], (4, 4, *poses[0].shape)))
    found = _sinew.CombinationKeys(skin, keys, keys, values, values, grid, twice, 1e-4, 0.0, 3)
    assert 0 < len(found) <= 3 and found.error_before > 1e-4 and found.error_at == 0.0
    assert found.correction(0).shape == corrections[0].shape
    assert all(row < len(found.first_at) and column < len(found.second_at) for row, column in found.corners)
    with pytest.raises(ValueError, match="key"):
        found.correction(len(found))


@pytest.mark.parametrize(
    "change, words",
    [
        ({"poses": np.zeros((24, 2, 4, 4), np.float32)}, "poses"),
        ({"corrections": np.zeros((25, 3, 3), np.float32)}, "corrections"),
        ({"at": np.zeros(25, np.float32)}, "at"),
        ({"at": np.zeros(25)}, "more than the previous one"),
        ({"tolerance": -1.0}, "tolerance: expected a number from 0 to 1e18, got -1"),
        ({"at": np.linspace(1.0, 2.0, 25)}, "rest pose"),
    ],
)
def test_values_that_do_not_fit_are_refused(bend, change, words):
    skin, poses, corrections = bend
    arguments = {"poses": poses, "corrections": corrections, "at": ANGLES, "tolerance": 1e-3, "threshold": 0.0} | change
    with pytest.raises(ValueError, match=words):
        _sinew.MotionKeys(skin, **arguments)
