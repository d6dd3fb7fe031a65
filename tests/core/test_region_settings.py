"""Settings by region through the binding: their effect on the skin, and refused arguments."""

import _sinew
import numpy as np
import pytest
from conftest import elasticity_of

REGIONAL = ("anchor_stiffness", "edge_stiffness", "slack", "relaxation", "fat_sliding")
STRENGTHS = ("volume", "crease", "contact")


def correction(limb, skin, angle=1.2):
    out = limb.out()
    skin.correct(limb.bent(angle), np.full(len(limb.tissues), 0.5, np.float32), out)
    return out


def ones(limb, body=1.0):
    return _sinew.Regional(body, np.ones(2, np.float32), np.ones(len(limb.mesh["points"]), np.float32))


def with_elasticity(limb, **settings):
    return limb.skin(elasticity=_sinew.Elasticity(**elasticity_of(limb), **settings))


def test_explicit_defaults_give_the_same_bits(limb):
    said = {name: ones(limb, 0.0 if name in ("slack", "fat_sliding") else 1.0) for name in REGIONAL}
    said |= {name: np.ones(2, np.float32) for name in STRENGTHS}
    skin = limb.skin(
        muscle_influence=ones(limb),
        elasticity=_sinew.Elasticity(**elasticity_of(limb), energy="AS_RIGID_AS_POSSIBLE", contacts=True, **said),
    )
    np.testing.assert_array_equal(correction(limb, skin), correction(limb, with_elasticity(limb)))


def test_a_muscle_without_influence_moves_no_vertex(limb):
    factors = np.ones(len(limb.mesh["points"]), np.float32)
    factors[::3] = 0.0
    skin = limb.skin(muscle_influence=_sinew.Regional(vertices=factors))
    plain, found = correction(limb, limb.skin()), correction(limb, skin)
    assert not found[::3].any() and plain[::3].any()
    np.testing.assert_array_equal(found[factors == 1.0], plain[factors == 1.0])
    assert skin.anchored < limb.skin().anchored


def test_the_factors_of_muscle_influence_multiply(limb):
    half = limb.skin(gain=4.0, muscle_influence=_sinew.Regional(0.25, np.full(2, 0.5, np.float32)))
    np.testing.assert_array_equal(correction(limb, half), correction(limb, limb.skin(gain=0.5)))


def test_later_changes_of_the_arrays_have_no_effect(limb):
    factors = np.zeros(len(limb.mesh["points"]), np.float32)
    regional = _sinew.Regional(vertices=factors)
    factors[:] = np.nan
    assert not correction(limb, limb.skin(muscle_influence=regional)).any()


@pytest.mark.parametrize("name", REGIONAL)
@pytest.mark.parametrize(
    ("regional", "words"),
    [
        (_sinew.Regional(-1.0), "{} is -1, must be finite and 0 or more"),
        (_sinew.Regional(1.0, np.array([1, -2], np.float32)), "bone 1: {} is -2"),
        (_sinew.Regional(1.0, np.ones(3, np.float32)), r"{}: expected 2 entries \(one per bone\), got 3"),
        (_sinew.Regional(1.0, None, np.ones(3, np.float32)), r"{}: expected 384 entries \(one per vertex\), got 3"),
        (_sinew.Regional(1.0, None, np.full(384, -0.5, np.float32)), "vertex 0: {} is -0.5"),
    ],
)
def test_a_setting_that_does_not_fit_is_refused_by_name(limb, name, regional, words):
    with pytest.raises(ValueError, match=words.format(name)):
        with_elasticity(limb, **{name: regional})
    with pytest.raises(ValueError, match=words.format("muscle_influence")):
        limb.skin(muscle_influence=regional)


@pytest.mark.parametrize("name", STRENGTHS)
@pytest.mark.parametrize("strength", [-0.5, 1.5])
def test_a_strength_outside_its_limits_is_refused_by_name(limb, name, strength):
    with pytest.raises(ValueError, match=f"bone 1: {name} is {strength}, must be 0 to 1"):
        with_elasticity(limb, **{name: np.array([1.0, strength], np.float32)})


@pytest.mark.parametrize(
    ("name", "value", "words"),
    [
        ("energy", "springs", "energy: expected AS_RIGID_AS_POSSIBLE or SPRINGS"),
        ("energy", 3, "energy"),
        ("anchor_stiffness", 2.0, "anchor_stiffness"),
        ("contacts", "yes", "contacts"),
    ],
)
def test_an_impossible_option_is_refused_by_name(limb, name, value, words):
    with pytest.raises((ValueError, TypeError), match=words):
        with_elasticity(limb, **{name: value})
