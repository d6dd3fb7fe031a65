"""Generated calls of `_sinew`: each gives a finite answer or one of the documented errors, and never changes its input."""

import ast
import math
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from valid_calls import LIMB, VERTICES, valid_calls

CALLS_IN_CI, ALL_CALLS = 300, 100_000
# SinewError is a ValueError
DOCUMENTED = (ValueError, TypeError)

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


@st.composite
def calls(draw):
    name = draw(st.sampled_from(sorted(valid_calls())))
    function, valid = valid_calls()[name]
    return name, function, {key: wrong(draw, value) for key, value in valid.items()}


def check(call):
    name, function, given_ = call
    before = {key: value.copy() for key, value in given_.items() if isinstance(value, np.ndarray) and key != "out"}
    try:
        answer = function(**given_)
    except DOCUMENTED as error:
        assert str(error), f"{name}: an error without words"
        answer = None
    else:
        for key, value in given_.items():
            if isinstance(value, float) and not math.isfinite(value):
                raise AssertionError(f"{name} took {key}={value}")
    for key, array in before.items():
        assert np.array_equal(given_[key], array, equal_nan=array.dtype.kind in "fc"), f"{name} changed {key}"
    out = given_.get("out")
    if answer is not None and isinstance(out, np.ndarray) and out.dtype.kind == "f":
        assert np.isfinite(out).all(), f"{name} gave numbers that are not finite"


def test_the_valid_calls_are_answered():
    for function, valid in valid_calls().values():
        function(**valid)


def test_every_function_is_called():
    """All names of the stub, except those that take nothing or that only hold results."""
    stub = ast.parse((Path(__file__).parents[2] / "rust/py/_sinew.pyi").read_text())
    called = {name.partition(" of ")[0] for name in valid_calls()}
    for node in stub.body:
        if isinstance(node, ast.FunctionDef):
            assert node.name in called
        elif isinstance(node, ast.ClassDef):
            methods = {method.name: method for method in node.body if isinstance(method, ast.FunctionDef)}
            assert "__new__" not in methods or node.name in called, node.name
            for name, method in methods.items():
                if not name.startswith("__") and not method.decorator_list:
                    assert f"{node.name}.{name}" in called, f"{node.name}.{name}"


@settings(max_examples=CALLS_IN_CI, deadline=None, derandomize=True, database=None, suppress_health_check=list(HealthCheck))
@given(calls())
def test_some_generated_calls(call):
    check(call)


@pytest.mark.slow
@settings(max_examples=ALL_CALLS, deadline=None, database=None, suppress_health_check=list(HealthCheck))
@given(calls())
def test_many_generated_calls(call):
    check(call)
