"""Generated calls of `_sinew`: each gives a finite answer or one of the documented errors, and never changes its input."""

import _sinew
import numpy as np
import pytest
from conftest import column_major, elasticity_of, make_limb, rotation
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

CALLS_IN_CI, ALL_CALLS = 300, 100_000
# SinewError is a ValueError
DOCUMENTED = (ValueError, TypeError)
LIMB = make_limb(around=6, along=5)
VERTICES = len(LIMB.mesh["points"])

ODD = (float("nan"), float("inf"), -float("inf"), 3.4e38, -3.4e38, 1e-45, 0.0, -0.0, -1.0, 1.0)
numbers = st.one_of(st.sampled_from(ODD), st.floats(width=32))
integers = st.one_of(st.integers(-3, 300), st.sampled_from((-(2**31), 2**31 - 1, 2**31, 2**63, -(2**63) - 1, 10**30)))
texts = st.one_of(st.sampled_from(("LINEAR", "BLENDED", "MUSCLE", "")), st.text(max_size=8))
KINDS = (np.float32, np.float64, np.int32, np.int64, np.uint8, np.bool_, np.complex64)


@st.composite
def changed(draw, array):
    """An array with some of its numbers, its shape, its kind or its order in memory changed, or the array itself."""
    array = np.array(array)
    for _ in range(draw(st.integers(0, 2))):
        what = draw(st.sampled_from(("numbers", "shape", "kind", "order", "slice", "size")))
        if what == "numbers" and array.size:
            place = draw(st.integers(0, array.size - 1))
            with np.errstate(all="ignore"):
                if array.dtype.kind == "f":
                    array.reshape(-1)[place] = draw(numbers)
                elif array.dtype == np.int32:
                    array.reshape(-1)[place] = draw(st.sampled_from((-1, 0, 1, VERTICES, 2**31 - 1, -(2**31))))
        elif what == "shape" and array.size:
            array = array.reshape(-1) if array.ndim > 1 else array[:, None]
        elif what == "kind":
            with np.errstate(all="ignore"):
                array = np.nan_to_num(array).astype(draw(st.sampled_from(KINDS)))
        elif what == "order":
            array = np.asfortranarray(array)
        elif what == "slice" and array.ndim:
            array = np.concatenate((array, array))[::2]
        elif what == "size" and array.ndim:
            array = array[: draw(st.integers(0, len(array)))].copy()
    return array


def wrong(draw, valid):
    """A value near a valid one: an array with changes, a number or a text of any size, or another kind of thing."""
    if draw(st.integers(0, 40)) == 0:
        return draw(st.sampled_from((None, object(), "x", [], {}, 10**30, LIMB.skeleton)))
    if isinstance(valid, np.ndarray):
        return draw(changed(valid))
    if draw(st.integers(0, 4)):
        return valid
    if isinstance(valid, bool):
        return draw(st.booleans())
    if isinstance(valid, int):
        return draw(integers)
    if isinstance(valid, float):
        return draw(numbers)
    if isinstance(valid, str):
        return draw(texts)
    if isinstance(valid, tuple):
        return tuple(draw(numbers) for _ in range(draw(st.integers(0, len(valid) + 1))))
    return valid


def arguments():
    """By name: what is called, with valid arguments. Made again for each call, because some are filled."""
    limb, rest = LIMB, {"skeleton": LIMB.skeleton}
    skin, pose = limb.skin(), column_major(np.stack([rotation((1, 0, 0), 0.3), rotation((0, 1, 0), 0.8)]))
    mesh, relaxed, out = limb.mesh, limb.relaxed, np.zeros((VERTICES, 3), np.float32)
    linear = {name: mesh[name] for name in ("points", "mesh_to_armature", "weight_offsets", "weight_bones", "weights")}
    surface = _sinew.RestSurface(mesh["points"], limb.triangles)
    shown = _sinew.ShownTissues(
        limb.skeleton, ["a"], np.array([0], np.int32), np.eye(4, dtype=np.float32)[None], np.zeros((1, 3), np.float32),
        np.array([[1, 0, 0, 0]], np.float32), np.ones((1, 3), np.float32), ["XYZ"],
    )  # fmt: skip
    posed = np.tile(np.eye(4, dtype=np.float32), (1, 1, 1))
    tissue = {
        "name": "a", "kind": "MUSCLE", "origin_bone": 0, "insertion_bone": 1, "centre": (0.03, 0.0, 0.3),
        "rotation": (1.0, 0.0, 0.0, 0.0), "semi_axes": (0.02, 0.02, 0.1), "origin_tendon": 0.02, "insertion_tendon": 0.03,
    }  # fmt: skip
    return {
        "Skeleton": (_sinew.Skeleton, {"names": ["a", "b"], "parents": np.array([-1, 0], np.int32), "rest": limb.rest}),
        "Tissue": (lambda **all_: _sinew.Tissue(*all_.values()), tissue),
        "Musculature": (_sinew.Musculature, rest | {"tissues": limb.tissues}),
        "Musculature.pose": (
            limb.musculature.pose,
            {"pose": pose, "tension": relaxed, "out": np.zeros((3, 4, 4), np.float32)},
        ),
        "Regional": (lambda **all_: _sinew.Regional(*all_.values()), {"value": 1.0, "bones": np.ones(2, np.float32)}),
        "Elasticity": (lambda **all_: _sinew.Elasticity(*all_.values()), elasticity_of(limb) | {"iterations": 3}),
        "Skin": (lambda **all_: limb.skin(**all_), {"falloff": 0.1, "softness": 0.01, "gain": 1.0, "anchoring": "BLENDED"}),
        "Skin of arrays": (lambda **all_: _sinew.Skin(limb.musculature, **all_), dict(mesh)),
        "Skin.correct": (skin.correct, {"pose": pose, "tension": relaxed, "out": out}),
        "Skin.deform": (skin.deform, {"pose": pose, "tension": relaxed, "out": out}),
        "LinearSkin": (lambda **all_: _sinew.LinearSkin(limb.skeleton, *all_.values()), linear),
        "RestSurface": (_sinew.RestSurface, {"points": mesh["points"], "triangles": limb.triangles}),
        "RestSurface.region": (surface.region, {"centre": (0.0, 0.0, 0.3), "radius": 0.1}),
        "RestSurface.deformed": (surface.deformed, {"points": mesh["points"]}),
        "ShownTissues.deltas": (shown.deltas, {"pose": pose, "posed": posed, "out": np.zeros((1, 13), np.float32)}),
        "Path": (_sinew.Path, {"points": np.array([[0, 0, 0], [0, 0, 1]], np.float64)}),
    }


@st.composite
def calls(draw):
    name = draw(st.sampled_from(sorted(arguments())))
    function, valid = arguments()[name]
    return name, function, {key: wrong(draw, value) for key, value in valid.items()}


def check(call):
    name, function, given_ = call
    before = {key: value.copy() for key, value in given_.items() if isinstance(value, np.ndarray) and key != "out"}
    try:
        answer = function(**given_)
    except DOCUMENTED as error:
        assert str(error), f"{name}: an error without words"
        answer = None
    except OverflowError:
        # PyO3 raises it for an integer that its type can't hold, before `_sinew` sees it
        assert any(isinstance(value, int) and not 0 <= value < 2**31 for value in given_.values()), name
        answer = None
    for key, array in before.items():
        assert np.array_equal(given_[key], array, equal_nan=array.dtype.kind in "fc"), f"{name} changed {key}"
    out = given_.get("out")
    if answer is not None and isinstance(out, np.ndarray) and out.dtype.kind == "f":
        assert np.isfinite(out).all(), f"{name} gave numbers that are not finite"


def test_the_valid_calls_are_answered():
    for name, (function, valid) in arguments().items():
        function(**valid)
        assert name


@settings(max_examples=CALLS_IN_CI, deadline=None, derandomize=True, database=None, suppress_health_check=list(HealthCheck))
@given(calls())
def test_some_generated_calls(call):
    check(call)


@pytest.mark.slow
@settings(max_examples=ALL_CALLS, deadline=None, database=None, suppress_health_check=list(HealthCheck))
@given(calls())
def test_many_generated_calls(call):
    check(call)
