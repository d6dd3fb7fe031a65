"""Fitting under a skin: rays, inside tests, tissues, surface transfer, paths, invalid arguments."""

import _sinew
import numpy as np
import pytest

CUBE_CORNERS = np.array([0, 2, 3, 1, 4, 5, 7, 6, 0, 1, 5, 4, 2, 6, 7, 3, 0, 4, 6, 2, 1, 3, 7, 5], np.int32)
CUBE_OFFSETS = np.arange(0, 25, 4, dtype=np.int32)


def cube(size=1.0, to_space=None):
    """A cube from -size to size, normals outward."""
    points = np.array([[x, y, z] for z in (-1, 1) for y in (-1, 1) for x in (-1, 1)], np.float32) * np.float32(size)
    return _sinew.PolygonMesh(points, CUBE_CORNERS, CUBE_OFFSETS, to_space)


def muscles(count=1, **changes):
    rows = dict(
        kinds=["MUSCLE"] * count,
        centres=np.zeros((count, 3)),
        rotations=np.tile([1.0, 0.0, 0.0, 0.0], (count, 1)),
        semi_axes=np.tile([0.9, 0.9, 0.5], (count, 1)),
        tendons=np.full((count, 2), 0.1),
        via_offsets=np.zeros(count + 1, np.int32),
        via_points=np.zeros((0, 3)),
    )
    return _sinew.PlacedTissues(**(rows | changes))


def test_rays_inside_tests_and_nearest_points():
    surface = _sinew.SkinSurface([cube()])
    assert (surface.size, surface.margin) == (2.0, pytest.approx(0.002))
    origins = np.array([[0.0, 0, 0], [0.5, 0, 0], [3, 0, 0], [3, 0, 0]])
    directions = np.array([[0.0, 0, 2], [1, 0, 0], [-1, 0, 0], [1, 0, 0]])
    distances = surface.distances_along(origins, directions)
    assert distances[:3].tolist() == [0.5, 0.5, 0.0] and np.isnan(distances[3])
    assert surface.are_inside(origins).tolist() == [True, True, False, False]
    points, away = surface.nearest(origins[1:3])
    assert points.tolist() == [[1.0, 0.0, 0.0], [1.0, 0.0, 0.0]] and away.tolist() == [0.5, 2.0]


def test_several_meshes_are_one_skin():
    moved = np.eye(4, dtype=np.float32)
    moved[3, 0] = 1.5  # column-major
    surface = _sinew.SkinSurface([cube(), cube(to_space=moved)])
    assert surface.size == 3.5
    [along] = surface.distances_along(np.array([[-0.5, 0.0, 0.0]]), np.array([[1.0, 0.0, 0.0]]))
    assert along == 3.0  # the first hit is one at which the ray enters
    assert surface.are_inside(np.array([[2.0, 0.0, 0.0]])).all()


def test_a_belly_near_the_skin_grows_up_to_it_and_one_too_thick_shrinks():
    surface = _sinew.SkinSurface([cube()])
    placed = muscles(2, semi_axes=np.array([[0.9, 0.9, 0.5], [1.5, 1.5, 0.5]]))
    assert surface.protrusions(placed)[1] > 0.3
    fitted = surface.fit(placed, np.array([-1, -1], np.int32))
    assert len(fitted) == 2
    assert fitted.semi_axes[:, :2] == pytest.approx(np.full((2, 2), 0.998), rel=0.05)
    assert (fitted.semi_axes[:, 2] == 0.5).all() and (fitted.tendons == 0.1).all()
    assert (surface.protrusions(fitted) == 0.0).all()


def test_a_muscle_that_no_skin_covers_is_unchanged():
    via = np.array([[9.0, 1.0, 2.0]])
    placed = muscles(centres=np.full((1, 3), 9.0), via_offsets=np.array([0, 1], np.int32), via_points=via)
    fitted = _sinew.SkinSurface([cube()]).fit(placed, np.array([-1], np.int32))
    for name in ("centres", "rotations", "semi_axes", "tendons", "via_offsets", "via_points"):
        assert (getattr(fitted, name) == getattr(placed, name)).all(), name


def test_the_right_is_the_image_of_the_left():
    sides = np.eye(4, dtype=np.float32), np.eye(4, dtype=np.float32)
    sides[0][3, 0], sides[1][3, 0] = 2.0, -2.0
    surface = _sinew.SkinSurface([cube(to_space=side) for side in sides])
    placed = muscles(2, centres=np.array([[2.1, 0.0, 0.0], [-2.1, 0.0, 0.0]]))
    fitted = surface.fit(placed, np.array([-1, 0], np.int32))
    assert (fitted.centres[1] == fitted.centres[0] * [-1, 1, 1]).all()
    assert (fitted.semi_axes[1] == fitted.semi_axes[0]).all()


def test_surface_transfer_takes_near_values():
    old, new = cube(), cube(0.99)
    transfer = _sinew.SurfaceTransfer(old, new, 0.1)
    values = np.stack((CUBE_CORNERS, np.ones(24)), axis=1).astype(np.float32)
    mixed = transfer.mixed(values)
    assert mixed.shape == (8, 2) and mixed[:, 1] == pytest.approx(np.ones(8))
    assert CUBE_CORNERS[transfer.nearest_corners].tolist() == list(range(8))
    assert transfer.nearest_faces.tolist() == list(range(6))
    far = _sinew.SurfaceTransfer(old, cube(3.0), 0.1)
    assert not far.is_near.any() and not far.mixed(values).any()


def test_paths():
    path = _sinew.Path(np.array([[0.0, 0, 0], [1, 0, 0], [1, 2, 0]]))
    assert path.length == 3.0 and path.at(2.0) == (1.0, 1.0, 0.0)
    assert path.nearest_length((5.0, 1.0, 0.0)) == 2.0
    assert _sinew.nearest_on_segment((0.5, 3.0, 0.0), (0, 0, 0), (2, 0, 0)) == ((0.5, 0.0, 0.0), 0.25)


def test_threads_change_no_bit():
    generator = np.random.default_rng(4)
    origins, directions = generator.normal(size=(2, 500, 3))
    surface = _sinew.SkinSurface([cube()])
    try:
        found = []
        for threads in (1, 3):
            _sinew.set_thread_count(threads)
            found.append(surface.distances_along(origins * 0.5, directions))
    finally:
        _sinew.set_thread_count(0)
    np.testing.assert_array_equal(*found)


def test_invalid_arguments_are_refused():
    points = np.zeros((3, 3), np.float32)
    corners, offsets = np.arange(3, dtype=np.int32), np.array([0, 3], np.int32)
    with pytest.raises(ValueError, match="face_offsets: entry 1 is 2"):
        _sinew.PolygonMesh(points, corners, np.array([0, 2], np.int32))
    with pytest.raises(ValueError, match="corners: entry 1 is 9"):
        _sinew.PolygonMesh(points, np.array([0, 9, 1], np.int32), offsets)
    with pytest.raises(ValueError, match="points: expected float32"):
        _sinew.PolygonMesh(points.astype(np.float64), corners, offsets)
    with pytest.raises(_sinew.SinewError, match="not affine"):
        _sinew.PolygonMesh(points, corners, offsets, np.ones((4, 4), np.float32))
    bare = _sinew.PolygonMesh(points, corners[:0], offsets[:1])
    for meshes in ([], [cube(), bare]):
        with pytest.raises(_sinew.SinewError, match="has no faces"):
            _sinew.SkinSurface(meshes)
    surface = _sinew.SkinSurface([cube()])
    with pytest.raises(ValueError, match="directions: expected 2"):
        surface.distances_along(np.zeros((2, 3)), np.ones((1, 3)))
    with pytest.raises(ValueError, match="left_twins: entry 0 is 7"):
        surface.fit(muscles(), np.array([7], np.int32))
    with pytest.raises(_sinew.SinewError, match="Tissue 0: semi-axis"):
        muscles(semi_axes=np.zeros((1, 3)))
    with pytest.raises(ValueError, match="kind"):
        muscles(kinds=["FAT"])
    with pytest.raises(ValueError, match="via_offsets"):
        muscles(via_offsets=np.array([0, 1], np.int32))
    with pytest.raises(ValueError, match="max_distance: expected a number from 0"):
        _sinew.SurfaceTransfer(cube(), cube(), -1.0)
    with pytest.raises(ValueError, match="values"):
        _sinew.SurfaceTransfer(cube(), cube(), 1.0).mixed(np.zeros((23, 1), np.float32))
    with pytest.raises(ValueError, match="points: expected one or more"):
        _sinew.Path(np.zeros((0, 3)))
