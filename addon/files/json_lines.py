# SPDX-License-Identifier: GPL-3.0-or-later
"""JSON with line numbers: what the standard parser forgets, looked up again once a fault is found."""

import json
import re
from json import decoder, scanner
from typing import Any

_NOT_A_NUMBER = re.compile(r'(?:"([^"\n]*)"\s*:\s*)?-?\b(?:NaN|Infinity)\b')


class Fault(Exception):
    """What is wrong with a text as JSON, and in which line."""

    def __init__(self, line: int, what: str) -> None:
        super().__init__(what)
        self.line = line


def parse(text: str) -> Any:
    """The text's value. Raises Fault for what isn't JSON: NaN, and a field that stands twice in one object, too."""
    try:
        return json.loads(text, object_pairs_hook=_without_twins, parse_constant=_refuse)
    except json.JSONDecodeError as error:
        raise Fault(error.lineno, f"not JSON ({error.msg})") from error
    except _Twin as twin:
        at = [found.start() for found in re.finditer(rf'"{re.escape(str(twin))}"\s*:', text)]
        raise Fault(_line(text, at[-1] if at else 0), f"'{twin}' stands twice in one object") from twin
    except ValueError as error:
        found = _NOT_A_NUMBER.search(text)
        field = f"'{found.group(1)}' " if found and found.group(1) else ""
        raise Fault(_line(text, found.start() if found else 0), f"{field}is not a number ({error})") from error
    except RecursionError as error:
        raise Fault(1, "not a preset (brackets within brackets without end)") from error


def line_of(text: str, path: list[str]) -> int:
    """The line of a value that is reached by these keys and indices; of the deepest object on the way that exists."""
    places: dict[int, int] = {}  # identity of an object or list to where it begins
    value = _with_places(text, places)
    position = 0
    for key in path:
        position = places.get(id(value), position)
        if isinstance(value, dict) and key in value:
            position = _field(text, position, key)
            value = value[key]
        elif isinstance(value, list) and key.isdigit() and int(key) < len(value):
            value = value[int(key)]
            position = places.get(id(value), position)
        else:
            break
    return _line(text, position)


class _Twin(Exception):
    pass


def _without_twins(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    table = dict(pairs)
    if len(table) < len(pairs):
        names = [name for name, _ in pairs]
        raise _Twin(next(name for name in names if names.count(name) > 1))
    return table


def _refuse(constant: str) -> Any:
    raise ValueError(constant)


def _with_places(text: str, places: dict[int, int]) -> Any:
    """The text's value again, by the standard library's slower parser, which can be asked where it is."""
    reader = json.JSONDecoder()
    reader.parse_object = lambda at, *rest: _noted(decoder.JSONObject(at, *rest), at[1], places)
    reader.parse_array = lambda at, *rest: _noted(decoder.JSONArray(at, *rest), at[1], places)
    reader.scan_once = scanner.py_make_scanner(reader)
    return reader.decode(text)


def _noted(result: tuple[Any, int], begin: int, places: dict[int, int]) -> tuple[Any, int]:
    places[id(result[0])] = begin
    return result


def _field(text: str, begin: int, key: str) -> int:
    found = re.compile(rf"{re.escape(json.dumps(key, ensure_ascii=False))}\s*:").search(text, begin)
    return found.start() if found else begin


def _line(text: str, position: int) -> int:
    return text.count("\n", 0, position) + 1
