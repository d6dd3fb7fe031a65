# SPDX-License-Identifier: GPL-3.0-or-later
"""Reads JSON files that may come from strangers: as data, within bounds, and with exact messages.

A file is parsed once (RFC 8259) into `Table` objects, which know where they and their fields are in the text. The caller
then reads each field by its name and type. Each error is a SinewError that names the file, the line and the field. Nothing
in a file is executed.

The parser is written here because Python's `json` reports no positions, accepts NaN and keeps the last of two equal fields.
"""

import json
import math
import re
from collections.abc import Collection
from json.decoder import scanstring
from pathlib import Path
from typing import Any

from ..errors import SinewError

MAX_FILE_BYTES = 8_000_000
MAX_DEPTH = 32  # objects and lists inside each other
MAX_VALUES = 1_000_000
MAX_NAME_BYTES = 63  # of a name in Blender
MAX_TEXTS = 100
MISSING = object()

_SPACE = re.compile(r"[ \t\n\r]*")
_NUMBER = re.compile(r"-?(?:0|[1-9][0-9]*)(\.[0-9]+)?([eE][+-]?[0-9]+)?")
_NOT_A_NUMBER = re.compile(r"NaN|-?Infinity")
_LONE_SURROGATE = re.compile("[\ud800-\udfff]")
_CONSTANTS = {"t": ("true", True), "f": ("false", False), "n": ("null", None)}
_LONGEST_EXACT_INTEGER = 18  # digits; longer ones are read as float, which takes linear time
_LONGEST_SHOWN = 40


class Table:
    """A JSON object. Each method reads one field and raises SinewError if it is missing or of another type."""

    def __init__(self, source: "_Source", start: int):
        self._source, self._start = source, start
        self._subject = ""
        self._path = ""  # the fields that lead from the subject's object to this one, each with a dot
        self._fields: dict[str, Any] = {}
        self._positions: dict[str, int] = {}
        self._read: set[str] = set()

    def describes(self, subject: str):
        """Sets the subject, such as the name of a tissue. Errors in this object, and in all inside it, begin with it."""
        self._subject, self._path = subject, ""

    def add(self, field: str, position: int, value: Any):
        """Adds a field that the parser read. Raises SinewError if the object has it already."""
        if field in self._fields:
            raise self._source.error(position, f"'{_shortened(field)}' appears twice in one object")
        self._fields[field], self._positions[field] = value, position

    def fault(self, field: str, what: str) -> SinewError:
        """An error that names the file, the line, the subject and the field."""
        subject = f"{self._subject}: " if self._subject else ""
        position = self._positions.get(field, self._start)
        return self._source.error(position, f"{subject}'{self._path}{_shortened(field)}' {what}")

    def fields(self) -> tuple[str, ...]:
        """The names of all fields, in the order of the file."""
        return tuple(self._fields)

    def has(self, field: str) -> bool:
        """Whether the object has a field."""
        return field in self._fields

    def get(self, field: str, default: Any = MISSING) -> Any:
        """The value of a field, of any type."""
        self._read.add(field)
        value = self._fields.get(field, default)
        if value is MISSING:
            raise self.fault(field, "is missing")
        return value

    def table(self, field: str) -> "Table":
        """An object."""
        value = self.get(field)
        if not isinstance(value, Table):
            raise self.fault(field, f"must be an object in braces, not {_shown(value)}")
        return value._inside(self, field)

    def tables(self, field: str, most: int, fewest: int = 0) -> list["Table"]:
        """A list of objects; `fewest` to `most` of them."""
        value = self.get(field)
        if not isinstance(value, list):
            raise self.fault(field, f"must be a list of objects in braces, not {_shown(value)}")
        for index, entry in enumerate(value):
            if not isinstance(entry, Table):
                raise self.fault(field, f"must be a list of objects in braces; entry {index + 1} is {_shown(entry)}")
        self._check_count(field, value, most, fewest)
        return [entry._inside(self, field) for entry in value]

    def text(self, field: str, max_bytes: int = MAX_NAME_BYTES) -> str:
        """A name: one line of printable characters, at most `max_bytes` in UTF-8."""
        value = self.get(field)
        if not isinstance(value, str) or not value.strip() or not value.isprintable():
            raise self.fault(field, f"must be a text, not {_shown(value)}")
        if len(value.encode()) > max_bytes:
            raise self.fault(field, f"is longer than {max_bytes} bytes: {_shown(value)}")
        return value

    def long_text(self, field: str, max_characters: int, may_be_empty: bool = False) -> str:
        """A text of any characters."""
        value = self.get(field)
        if not isinstance(value, str) or not (may_be_empty or value.strip()):
            raise self.fault(field, f"must be a text, not {_shown(value)}")
        if len(value) > max_characters:
            raise self.fault(field, f"is longer than {max_characters} characters: {_shown(value)}")
        return value

    def texts(self, field: str, most: int = MAX_TEXTS) -> tuple[str, ...]:
        """A list of texts, none of them empty."""
        value = self.get(field)
        if not isinstance(value, list) or not all(isinstance(entry, str) and entry for entry in value):
            raise self.fault(field, f"must be a list of texts, not {_shown(value)}")
        self._check_count(field, value, most)
        return tuple(value)

    def one_of(self, field: str, known: Collection[str]) -> str:
        """One of these texts."""
        value = self.get(field)
        if not isinstance(value, str) or value not in known:
            raise self.fault(field, f"must be one of {', '.join(known)}, not {_shown(value)}")
        return value

    def flag(self, field: str) -> bool:
        """True or false."""
        value = self.get(field)
        if not isinstance(value, bool):
            raise self.fault(field, f"must be true or false, not {_shown(value)}")
        return value

    def number(self, field: str, low: float, high: float) -> float:
        """A number from `low` to `high`."""
        value = self.get(field)
        if not _is_number(value) or not low <= value <= high:
            raise self.fault(field, f"must be a number from {low:g} to {high:g}, not {_shown(value)}")
        return float(value)

    def numbers(self, field: str, count: int, low: float, high: float) -> tuple[float, ...]:
        """A list of `count` numbers, each from `low` to `high`."""
        value = self.get(field)
        if not isinstance(value, list) or len(value) != count or not all(map(_is_number, value)):
            raise self.fault(field, f"must be a list of {count} numbers, not {_shown(value)}")
        if not all(low <= entry <= high for entry in value):
            raise self.fault(field, f"must have numbers from {low:g} to {high:g}, not {_shown(value)}")
        return tuple(map(float, value))

    def finish(self):
        """Raises SinewError if the object has a field that nothing has read."""
        unknown = next((field for field in self._fields if field not in self._read), None)
        if unknown is not None:
            raise self.fault(unknown, "is not a field that Sinew knows here")

    def _check_count(self, field: str, entries: list, most: int, fewest: int = 0):
        if len(entries) < fewest:
            raise self.fault(field, f"has {len(entries)} entries; it must have {fewest} or more")
        if len(entries) > most:
            raise self.fault(field, f"has {len(entries)} entries; at most {most} can be read")

    def _inside(self, parent: "Table", field: str) -> "Table":
        """This object, with the subject and the path of the field of the parent that holds it."""
        self._subject, self._path = parent._subject, f"{parent._path}{field}."
        return self


def read(path: Path, max_bytes: int = MAX_FILE_BYTES) -> Table:
    """The JSON object in a file. Raises SinewError, naming the file and the line."""
    try:
        with open(path, "rb") as file:
            content = file.read(max_bytes + 1)
    except OSError as error:
        raise SinewError(f"{_shown_name(path)}: can't be read ({error.strerror}): choose another file") from error
    except ValueError as error:  # a character that no path can have
        raise SinewError(f"{_shown_name(path)}: not the name of a file: choose another file") from error
    if len(content) > max_bytes:
        raise SinewError(f"{_shown_name(path)}: too large (at most {max_bytes // 1_000_000} MB can be read)")
    try:
        text = content.decode("utf-8")
    except UnicodeDecodeError as error:
        raise SinewError(f"{_shown_name(path)}: not a JSON file in UTF-8 ({error.reason})") from error
    return _Parser(_Source(_shown_name(path), text)).table()


class _Source:
    """The text of a file, to turn positions into lines."""

    def __init__(self, name: str, text: str):
        self.name, self.text = name, text

    def error(self, position: int, what: str) -> SinewError:
        line = self.text.count("\n", 0, position) + 1
        return SinewError(f"{self.name}, line {line}: {what}")


class _Parser:
    """A recursive-descent parser. Methods take a position in the text and return a value with the position after it."""

    def __init__(self, source: _Source):
        self._source, self._text = source, source.text
        self._value_count = 0

    def table(self) -> Table:
        """The object that the whole text is."""
        begin = self._after_space(0)
        value, end = self._value(begin, 0, "")
        if not isinstance(value, Table):
            raise self._source.error(begin, f"must be an object in braces, not {_shown(value)}")
        end = self._after_space(end)
        if end < len(self._text):
            raise self._not_json(end, "text after the last brace")
        return value

    def _value(self, begin: int, depth: int, field: str) -> tuple[Any, int]:
        """field: the name of the field that the value belongs to, for messages."""
        self._value_count += 1
        if self._value_count > MAX_VALUES:
            raise self._source.error(begin, f"more than {MAX_VALUES} values; no more can be read")
        first = self._text[begin : begin + 1]
        if first == '"':
            return self._string(begin)
        if first == "{" or first == "[":
            if depth == MAX_DEPTH:
                raise self._source.error(begin, f"more than {MAX_DEPTH} objects and lists inside each other")
            return self._object(begin, depth + 1) if first == "{" else self._list(begin, depth + 1, field)
        word, constant = _CONSTANTS.get(first, ("", None))
        if word and self._text.startswith(word, begin):
            return constant, begin + len(word)
        return self._number(begin, field)

    def _object(self, begin: int, depth: int) -> tuple[Table, int]:
        table = Table(self._source, begin)
        at = first = self._after_space(begin + 1)
        while self._text[at : at + 1] != "}":
            if at != first:
                at = self._after(at, ",")
            name_at = at
            if self._text[at : at + 1] != '"':
                raise self._not_json(at, "the name of a field in quotes is expected")
            field, at = self._string(at)
            value, at = self._value(self._after(self._after_space(at), ":"), depth, field)
            table.add(field, name_at, value)
            at = self._after_space(at)
        return table, at + 1

    def _list(self, begin: int, depth: int, field: str) -> tuple[list, int]:
        values: list = []
        at = first = self._after_space(begin + 1)
        while self._text[at : at + 1] != "]":
            if at != first:
                at = self._after(at, ",")
            value, at = self._value(at, depth, field)
            values.append(value)
            at = self._after_space(at)
        return values, at + 1

    def _string(self, begin: int) -> tuple[str, int]:
        try:
            text, end = scanstring(self._text, begin + 1, True)
        except json.JSONDecodeError as error:
            raise self._not_json(error.pos, error.msg) from error
        if _LONE_SURROGATE.search(text):
            raise self._not_json(begin, "half of a surrogate pair")
        return text, end

    def _number(self, begin: int, field: str) -> tuple[int | float, int]:
        match = _NUMBER.match(self._text, begin)
        if match is None:
            refused = _NOT_A_NUMBER.match(self._text, begin)
            if refused:
                raise self._source.error(begin, f"'{_shortened(field)}' has {refused[0]}, which is not a number")
            raise self._not_json(begin, "a value is expected")
        is_integer = not (match[1] or match[2]) and len(match[0]) <= _LONGEST_EXACT_INTEGER
        number = int(match[0]) if is_integer else float(match[0])
        if not math.isfinite(number):
            raise self._source.error(begin, f"'{_shortened(field)}' has {_shortened(match[0])}, which is too large a number")
        return number, match.end()

    def _after(self, at: int, mark: str) -> int:
        """The next position that is not white space, after a mark. Raises SinewError if the mark is not at `at`."""
        if self._text[at : at + 1] != mark:
            raise self._not_json(at, f"'{mark}' is expected")
        return self._after_space(at + 1)

    def _after_space(self, at: int) -> int:
        return _SPACE.match(self._text, at).end()

    def _not_json(self, position: int, what: str) -> SinewError:
        return self._source.error(position, f"not JSON ({what})")


def _shown_name(path: Path) -> str:
    """The name of a file, for messages. A name that is not UTF-8 has lone surrogates in Python."""
    return path.name.encode("utf-8", "backslashreplace").decode()


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)


def _shown(value: Any) -> str:
    if isinstance(value, Table):
        return "an object"
    return _shortened(json.dumps(value, default=lambda _: "{...}"))


def _shortened(text: str) -> str:
    return text if len(text) <= _LONGEST_SHOWN else f"{text[: _LONGEST_SHOWN - 3]}..."
