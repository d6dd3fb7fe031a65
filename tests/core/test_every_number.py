"""Each number of each function of `_sinew`, replaced in turn: NaN, infinities and numbers beyond 1e18 are refused by the
name of the argument and by value, and any other number gives a finite answer or a documented error."""

import math

import numpy as np
import pytest
from valid_calls import valid_calls

LARGEST = 1e18  # that of the core
REFUSED = (math.nan, math.inf, -math.inf, 2.0 * LARGEST, -2.0 * LARGEST)
TAKEN = (0.0, -1.0, 0.9 * LARGEST, -0.9 * LARGEST, 1e-300)
WHOLE = (0, -1, 2**31 - 1, -(2**31), 2**40, -(2**63) - 1, 10**400)
MAY_BE_NAN = ("SkinSurface.distances_along",)  # where a ray hits nothing


def in_turn(value, numbers):
    """Pairs of a label and a copy of `value` with one of its numbers replaced: each number of a tuple or list, and the
    first, the middle, the last and all of an array."""
    if isinstance(value, (bool, str)):
        return
    if isinstance(value, (int, float)):
        yield from ((f"={number}", number) for number in numbers)
    elif isinstance(value, (tuple, list)):
        for index, entry in enumerate(value):
            for label, changed in in_turn(entry, numbers):
                yield f"[{index}]{label}", type(value)([*value[:index], changed, *value[index + 1 :]])
    elif isinstance(value, np.ndarray) and value.dtype.kind == "f" and value.size:
        for number in numbers:
            for place in (0, value.size // 2, value.size - 1, slice(None)):
                changed = value.copy()
                changed.reshape(-1)[place] = number
                yield f"[{place}]={number}", changed


def calls(numbers, is_meant):
    """The label, the function, the name of the changed argument and the arguments of each changed call. is_meant: whether
    an argument with this valid value is changed."""
    for name, (function, valid) in sorted(valid_calls().items()):
        for key, value in valid.items():
            if key != "out" and is_meant(value):  # `out` is only written
                for label, changed in in_turn(value, numbers):
                    yield f"{name}({key}{label})", function, key, valid | {key: changed}


def is_of_numbers(value) -> bool:
    return not (isinstance(value, int) or (isinstance(value, list) and value and isinstance(value[0], int)))


def not_finite_in(answer, depth: int = 0) -> bool:
    """Whether a NaN or an infinity is in an answer: a number, an array, a sequence, or a property of an object."""
    if isinstance(answer, float):
        return not math.isfinite(answer)
    if isinstance(answer, np.ndarray):
        return answer.dtype.kind == "f" and not np.isfinite(answer).all()
    if isinstance(answer, (tuple, list)):
        return any(not_finite_in(entry, depth) for entry in answer)
    if type(answer).__module__ == "_sinew" and depth == 0:
        found = (getattr(answer, name) for name in dir(answer) if not name.startswith("_"))
        return any(not_finite_in(value, depth + 1) for value in found if not callable(value))
    return False


def test_numbers_that_are_not_finite_or_too_large_are_refused_by_name_and_value():
    faults, count = [], 0
    for label, function, key, arguments in calls(REFUSED, lambda _value: True):
        count += 1
        try:
            function(**arguments)
        except ValueError as error:
            message = str(error).lower()
            if key.lower() not in message or not any(
                found in message for found in ("nan", "inf", "2e18", "2e+18", "2000000000000000000")
            ):
                faults.append(f"{label}: {error}")
        else:
            faults.append(f"{label} was accepted")
    assert not faults, f"{len(faults)} of {count}\n" + "\n".join(faults)
    assert count > 1500


@pytest.mark.parametrize(("numbers", "is_meant"), [(TAKEN, is_of_numbers), (WHOLE, lambda value: not is_of_numbers(value))])
def test_other_numbers_give_a_finite_answer_or_an_error_with_words(numbers, is_meant):
    faults = []
    for label, function, _key, arguments in calls(numbers, is_meant):
        try:
            answer = function(**arguments)
        except ValueError as error:
            if not str(error):
                faults.append(f"{label}: an error without words")
            continue
        out = arguments.get("out")
        if (not_finite_in(answer) and not label.startswith(MAY_BE_NAN)) or (out is not None and not_finite_in(out)):
            faults.append(f"{label} gave numbers that are not finite")
    assert not faults, "\n".join(faults)
