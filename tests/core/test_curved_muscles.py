"""Curved muscles through the binding: belly chains, paths, and refused arguments."""

import _sinew
import numpy as np
import pytest
from conftest import column_major, rotation
from hypothesis import given
from hypothesis import strategies as st

REST = column_major(np.stack([np.eye(4), np.eye(4)]))
SKELETON = _sinew.Skeleton(["upper", "lower"], np.array([-1, 0], np.int32), REST)
RADIUS = 0.025
ELBOW = _sinew.Tissue("elbow", "SPHERE", 1, 1, (0, 0, 0), (1, 0, 0, 0), (RADIUS,) * 3)
BONE = _sinew.Tissue("humerus", "BONE", 0, 0, (0, 0, 0.15), (1, 0, 0, 0), (0.01, 0.01, 0.15))
# behind a hinge at the origin, from 0.26 m above it to 0.06 m below it
TRICEPS = ("triceps", "MUSCLE", 0, 1, (-0.035, 0, 0.12), (0, 1, 0, 0), (0.02, 0.015, 0.1), 0.04, 0.04)


def muscle(**path):
    return _sinew.Tissue(*TRICEPS, **path)


def musculature(**path):
    return _sinew.Musculature(SKELETON, [BONE, muscle(**path), ELBOW])


def bent(degrees):
    return column_major(np.stack([np.eye(4), rotation((0, -1, 0), np.radians(degrees))]))


def ellipsoids(made, pose, tension=0.0):
    out = np.empty((made.ellipsoid_count, 4, 4), np.float32)
    made.pose_ellipsoids(pose, np.full(len(made), tension, np.float32), out)
    return out.astype(np.float64)


def volumes(matrices):
    return 4 / 3 * np.pi * abs(np.linalg.det(matrices[:, :3, :3]))


WRAPPED = musculature(wraps=["elbow"])
GUIDED = musculature(via_points=[(0, (-0.06, 0.0, 0.1)), (1, (-0.05, 0.01, -0.03))], wraps=("elbow",))


def test_ellipsoids_and_their_tissues():
    assert WRAPPED.ellipsoid_tissue.dtype == np.int32
    assert WRAPPED.ellipsoid_tissue.tolist() == [0] * 3 + [1] * 5 + [2]
    assert WRAPPED.ellipsoid_count == 9 and musculature().ellipsoid_count == 5
    with pytest.raises(AttributeError):
        WRAPPED.ellipsoid_count = 1


@pytest.mark.parametrize("made", [WRAPPED, GUIDED, musculature()])
@given(degrees=st.floats(0, 150), tension=st.floats(0, 1, width=32))
def test_every_ellipsoid_keeps_its_volume(made, degrees, tension):
    np.testing.assert_allclose(volumes(ellipsoids(made, bent(degrees), tension)), volumes(ellipsoids(made, REST)), rtol=2e-6)
    out = np.empty((3, 4, 4), np.float32)
    posed, rest = (made.pose(pose, np.full(3, tension, np.float32), out) for pose in (bent(degrees), REST))
    np.testing.assert_allclose(posed.volume, rest.volume, rtol=1e-6)


@given(degrees=st.floats(0, 150))
def test_the_path_stays_outside_the_sphere_and_agrees_with_the_stretch(degrees):
    points, offsets = WRAPPED.path_points(bent(degrees))
    assert points.dtype == np.float32 and offsets.dtype == np.int32
    assert offsets[0] == offsets[1] == 0 and offsets[2] == offsets[3] == len(points)
    assert np.linalg.norm(points, axis=1).min() > RADIUS + 0.004
    length = np.linalg.norm(np.diff(points.astype(np.float64), axis=0), axis=1).sum()
    posed = WRAPPED.pose(bent(degrees), np.zeros(3, np.float32), np.empty((3, 4, 4), np.float32))
    rest_points, _ = WRAPPED.path_points(REST)
    rest = np.linalg.norm(np.diff(rest_points.astype(np.float64), axis=0), axis=1).sum()
    assert posed.stretch[1] == pytest.approx((length - 0.08) / (rest - 0.08), rel=1e-4)
    chain = ellipsoids(WRAPPED, bent(degrees))[WRAPPED.ellipsoid_tissue == 1]
    assert np.linalg.norm(chain[:, 3, :3], axis=1).min() > RADIUS


def test_a_sphere_off_the_path_leaves_the_muscle_straight():
    straight, wrapped = musculature(), musculature(wraps=["elbow"])
    frames = [np.empty((3, 4, 4), np.float32) for _ in range(2)]
    for degrees in (0, -30, -90):
        for made, out in zip((straight, wrapped), frames):
            made.pose(bent(degrees), np.zeros(3, np.float32), out)
        np.testing.assert_allclose(*frames, atol=1e-7)


def test_the_rest_pose_gives_the_rest_shape():
    out = np.empty((3, 4, 4), np.float32)
    GUIDED.pose(REST, np.zeros(3, np.float32), out)
    rest_matrix = [[0.02, 0, 0, 0], [0, -0.015, 0, 0], [0, 0, -0.1, 0], [-0.035, 0, 0.12, 1]]
    np.testing.assert_allclose(out[1], rest_matrix, atol=1e-7)


def test_straight_paths_have_two_points():
    points, offsets = musculature().path_points(REST)
    assert offsets.tolist() == [0, 0, 2, 2]
    np.testing.assert_allclose(points, [[-0.035, 0, 0.26], [-0.035, 0, -0.02]], atol=1e-7)


@pytest.mark.parametrize(
    ("path", "named"),
    [
        ({"via_points": [(-1, (0, 0, 0))]}, "via point"),
        ({"via_points": [(0, (0, 0))]}, "^via_points: expected"),
        ({"via_points": [(0, (0, 0, float("nan")))]}, "^via_points: expected"),
        ({"via_points": [1]}, "^via_points: expected"),
        ({"via_points": 3}, "^via_points: expected"),
        ({"wraps": "elbow"}, "^wraps: expected"),
        ({"wraps": [1]}, "^wraps: expected"),
    ],
)
def test_a_malformed_path_is_refused_by_name(path, named):
    with pytest.raises(ValueError, match=named):
        muscle(**path)


def test_an_impossible_path_is_refused_by_name():
    with pytest.raises(_sinew.SinewError, match="humerus.*rigid"):
        _sinew.Tissue("humerus", "BONE", 0, 0, (0, 0, 0), (1, 0, 0, 0), (1, 1, 1), wraps=["elbow"])
    for path, named in (
        ({"wraps": ["knee"]}, "triceps.*knee.*not in the musculature"),
        ({"wraps": ["humerus"]}, "triceps.*humerus.*not a sphere"),
        ({"via_points": [(2, (0, 0, 0))]}, "triceps.*via point.*2"),
    ):
        with pytest.raises(_sinew.SinewError, match=named):
            musculature(**path)


def test_arrays_are_checked():
    relaxed = np.zeros(3, np.float32)
    with pytest.raises(ValueError, match="^out: expected.*E = 9"):
        WRAPPED.pose_ellipsoids(REST, relaxed, np.empty((3, 4, 4), np.float32))
    with pytest.raises(ValueError, match="^pose: expected"):
        WRAPPED.path_points(REST.astype(np.float64))
    out = np.full((9, 4, 4), 7, np.float32)
    with pytest.raises(ValueError, match="tension"):
        WRAPPED.pose_ellipsoids(REST, np.array([0, 2, 0], np.float32), out)
    assert (out == 7).all()
