"""Each number that `_sinew` takes is checked: NaN, infinity and whole numbers that do not fit are refused."""

import numpy as np
import pytest
from test_generated_calls import UNLIMITED
from valid_calls import LIMB, valid_calls


def parameters(kind):
    """(call, parameter) of all parameters of a type."""
    return [
        (name, key)
        for name, (_function, valid) in valid_calls().items()
        for key, value in valid.items()
        if type(value) is kind
    ]


@pytest.mark.parametrize("number", [float("nan"), float("inf"), -float("inf")])
@pytest.mark.parametrize(("name", "key"), parameters(float))
def test_numbers_that_are_not_finite_are_refused(name, key, number):
    if name == "Regional":
        pytest.skip("`Skin` and `Elasticity` check it")
    if key in UNLIMITED and number > 0.0:
        pytest.skip("may be infinite")
    function, valid = valid_calls()[name]
    with pytest.raises(ValueError):
        function(**(valid | {key: number}))


@pytest.mark.parametrize("number", [-(2**63) - 1, 2**64, 10**30])
@pytest.mark.parametrize(("name", "key"), parameters(int))
def test_whole_numbers_that_do_not_fit_are_refused_by_name(name, key, number):
    function, valid = valid_calls()[name]
    with pytest.raises(ValueError, match=f"{key}: expected a whole number from .* got {number}"):
        function(**(valid | {key: number}))


def test_a_pose_that_is_not_affine_is_refused_where_muscles_are_shown():
    function, valid = valid_calls()["ShownTissues.deltas"]
    pose = LIMB.rest.copy()
    pose[0, 0, 3] = 0.5  # the last row, column-major
    with pytest.raises(ValueError, match="affine|projective|last row"):
        function(**(valid | {"pose": pose}))
    assert np.isfinite(LIMB.rest).all()
