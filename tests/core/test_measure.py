"""Measuring through the binding: the numbers of a bent limb, and refused arguments."""

import _sinew
import numpy as np
import pytest
from conftest import elasticity_of


@pytest.fixture(scope="session")
def surface(limb):
    return _sinew.RestSurface(limb.mesh["points"], limb.triangles)


def deformed(limb, angle):
    out = limb.out()
    limb.skin().deform(limb.bent(angle), limb.relaxed, out)
    return out


def test_the_rest_pose_has_no_change(limb, surface):
    quality = surface.deformed(limb.mesh["points"]).quality(surface.whole())
    assert (quality.union, quality.volume, quality.edge_max, quality.area_p99) == (1.0, 1.0, 1.0, 1.0)
    assert (quality.inverted, quality.new_intersections, quality.overlap, quality.bend_p99) == (0, 0, 0.0, 0.0)
    assert surface.rest_hits == 0


def test_a_bent_limb_and_its_joint(limb, surface):
    joint = surface.region((0.0, 0.0, 0.3), 0.1)
    found = surface.deformed(deformed(limb, 1.8))
    quality, whole = found.quality(joint), found.quality(surface.whole())
    assert len(joint) == len(joint.faces) < len(surface.whole())
    assert quality.union < whole.union < 1.0 and quality.edge_p99 > whole.edge_p50
    assert quality.inverted <= found.inverted.sum() and quality.new_intersections <= len(found.new_intersections)
    assert found.inverted.dtype == bool and found.new_intersections.shape[1] == 2
    assert found.vertex_stretch.max() > 1.2 and found.vertex_stretch[0] == pytest.approx(1.0, abs=1e-3)


def test_elastic_skin_measures_better(limb, surface):
    elastic = limb.skin(elasticity=_sinew.Elasticity(**elasticity_of(limb)))
    out = limb.out()
    elastic.deform(limb.bent(1.8), limb.relaxed, out)
    joint = surface.region((0.0, 0.0, 0.3), 0.15)  # half a segment, the range of the volume constraint of the joint
    elastic, plain = (surface.deformed(points).quality(joint) for points in (out, deformed(limb, 1.8)))
    assert abs(elastic.union - 1.0) < 0.5 * abs(plain.union - 1.0)


def test_carried_vertices_limit_a_region(limb, surface):
    lower = limb.mesh["points"][:, 2] > 0.3
    both, one = surface.region((0, 0, 0.3), 0.1), surface.region((0, 0, 0.3), 0.1, lower)
    assert set(one.faces) < set(both.faces)
    assert surface.region((9, 0, 0.3), 0.1) is None
    assert surface.region((0, 0, 0.3), 0.1, np.zeros_like(lower)) is None


def test_a_jump_is_measured_as_a_pop(limb):
    frames = np.stack([deformed(limb, angle) for angle in np.linspace(0.0, 0.3, 12)])
    still = _sinew.SkinMotion(frames, frames)
    assert (still.pop_excess, still.jitter_excess_p99) == (0.0, 0.0) and still.pop_max > 0.0
    jumping = frames.copy()
    jumping[6:, 300, 1] += 0.01
    motion = _sinew.SkinMotion(jumping, frames)
    assert motion.pop_excess == pytest.approx(0.01, rel=1e-4)
    assert (motion.pop_frame, motion.pop_vertex) == (5, 300)
    assert motion.pop_persistence == pytest.approx(1.0, rel=1e-4)
    others = np.arange(frames.shape[1]) != 300
    assert _sinew.SkinMotion(jumping, frames, others).pop_excess == 0.0


def test_the_axis_of_a_joint_is_perpendicular_to_its_muscle(limb):
    [(child, axis, bends_one_way)] = limb.musculature.joints()
    # the flexor is parallel to z at positive x beside the joint, so it rotates the joint about y
    assert child == 1 and abs(axis[1]) == pytest.approx(1.0, abs=1e-6)
    assert isinstance(bends_one_way, bool)


def test_impossible_measurements_are_refused(limb, surface):
    points, triangles = limb.mesh["points"], limb.triangles
    with pytest.raises(_sinew.SinewError, match="no vertices"):
        _sinew.RestSurface(points[:0], triangles[:0])
    with pytest.raises(ValueError, match="99999"):
        _sinew.RestSurface(points, np.array([[0, 1, 99999]], np.int32))
    with pytest.raises(ValueError, match="points"):
        surface.deformed(points[1:])
    with pytest.raises(ValueError, match="NaN"):
        surface.deformed(np.full_like(points, np.nan))
    with pytest.raises(ValueError, match="carried"):
        surface.region((0, 0, 0), 1.0, np.ones(3, bool))
    with pytest.raises(ValueError, match="another surface"):
        surface.deformed(points).quality(_sinew.RestSurface(points, triangles).whole())
    with pytest.raises(ValueError, match="reference"):
        _sinew.SkinMotion(np.zeros((3, 4, 3), np.float32), np.zeros((2, 4, 3), np.float32))
    with pytest.raises(ValueError, match="none"):
        _sinew.SkinMotion(np.zeros((3, 0, 3), np.float32), np.zeros((3, 0, 3), np.float32))


def test_a_mesh_of_one_vertex(limb):
    lone = _sinew.RestSurface(np.zeros((1, 3), np.float32), np.zeros((0, 3), np.int32))
    quality = lone.deformed(np.ones((1, 3), np.float32)).quality(lone.whole())
    assert (quality.union, quality.edge_max, quality.bend_p99) == (1.0, 1.0, 0.0)
