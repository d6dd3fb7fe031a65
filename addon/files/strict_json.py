# SPDX-License-Identifier: GPL-3.0-or-later
"""Reads JSON files that may come from strangers: as data, within bounds, and with exact messages.

A file is an object, a `Table`, and the caller reads each of its fields by name and type. Each error is a SinewError that
names the file, the line and the field. Nothing in a file is executed.

Python's `json` reports no positions, accepts NaN and keeps the last of two equal fields. So a table finds the positions of
its fields, and parses a field when it is read. `json` in C only skips over the values between, and finds what is not JSON. A
file that is refused costs little time then, however large it is.
"""

import gc
import json
import math
import re
import stat
from collections.abc import Collection, Iterator
from json.decoder import scanstring
from pathlib import Path
from typing import Any

from ..errors import SinewError

MAX_FILE_BYTES = 8_000_000
MAX_DEPTH = 8  # objects and lists inside each other
MAX_VALUES = 250_000
MAX_ENTRIES, MAX_FIELDS = 5000, 1000  # of a list, of an object
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
        self._known: dict[str, tuple[int, int]] | None = None
        self._values: dict[str, Any] = {}
        self.end = start  # the position after the object, once a field was read

    @property
    def _fields(self) -> dict[str, tuple[int, int]]:
        """The positions of the name and the value of each field."""
        if self._known is None:
            self._known = {}
            fields, self.end = self._source.fields_at(self._start)
            for field, name_at, value_at in fields:
                if field in self._known:
                    raise self._source.error(name_at, f"'{_shortened(field)}' appears twice in one object")
                self._known[field] = name_at, value_at
        return self._known

    def describes(self, subject: str):
        """Sets the subject, such as the name of a tissue. Errors in this object, and in all inside it, begin with it."""
        self._subject, self._path = subject, ""

    def fault(self, field: str, what: str) -> SinewError:
        """An error that names the file, the line, the subject and the field."""
        subject = f"{self._subject}: " if self._subject else ""
        position = self._fields[field][0] if field in self._fields else self._start
        return self._source.error(position, f"{subject}'{self._path}{_shortened(field)}' {what}")

    def fields(self) -> tuple[str, ...]:
        """The names of all fields, in the order of the file."""
        return tuple(self._fields)

    def has(self, field: str) -> bool:
        """Whether the object has a field."""
        return field in self._fields

    def get(self, field: str, default: Any = MISSING) -> Any:
        """The value of a field, of any type."""
        if field not in self._fields:
            if default is MISSING:
                raise self.fault(field, "is missing")
            return default
        if field not in self._values:
            self._values[field] = self._source.value_at(self._fields[field][1], field)
        return self._values[field]

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
        wrong = wrong_name(value, max_bytes)
        if wrong:
            raise self.fault(field, wrong)
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

    def integer(self, field: str, low: int, high: int) -> int:
        """A whole number from `low` to `high`, written without a point."""
        value = self.get(field)
        if not isinstance(value, int) or isinstance(value, bool) or not low <= value <= high:
            raise self.fault(field, f"must be a whole number from {low} to {high}, not {_shown(value)}")
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
        unknown = next((field for field in self._fields if field not in self._values), None)
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
        if not stat.S_ISREG(path.stat().st_mode):
            raise SinewError(f"{_shown_name(path)}: not a file with text. Choose another file")
        with open(path, "rb") as file:
            content = file.read(max_bytes + 1)
    except OSError as error:
        raise SinewError(f"{_shown_name(path)}: can't be read ({error.strerror}). Choose another file") from error
    except ValueError as error:  # a character that no path can have
        raise SinewError(f"{_shown_name(path)}: not the name of a file. Choose another file") from error
    if len(content) > max_bytes:
        raise SinewError(f"{_shown_name(path)}: too large (at most {max_bytes / 1e6:g} MB can be read)")
    try:
        text = content.decode("utf-8")
    except UnicodeDecodeError as error:
        raise SinewError(f"{_shown_name(path)}: not a JSON file in UTF-8 ({error.reason})") from error
    return parse(_shown_name(path), text)


def parse(name: str, text: str) -> Table:
    """The JSON object that a text is. name: the file's, for messages. Raises SinewError."""
    return _Source(name, text).table()


def wrong_name(value: Any, max_bytes: int = MAX_NAME_BYTES) -> str:
    """What is wrong with a value as a name, after the field's name in a message. Empty where `Table.text` accepts it."""
    if not isinstance(value, str) or not value.strip() or not value.isprintable():
        return f"must be a text, not {_shown(value)}"
    if len(value.encode()) > max_bytes:
        return f"is longer than {max_bytes} bytes: {_shown(value)}"
    return ""


# Numbers become float, which takes linear time. NaN and numbers that are too large are found when their field is read.
_skip = json.JSONDecoder(parse_constant=float, parse_int=float).scan_once


class _Source:
    """The text of a file. Positions are indices into it; the value of a field is parsed when it is read."""

    def __init__(self, name: str, text: str):
        self.name, self.text = name, text

    def error(self, position: int, what: str) -> SinewError:
        """An error that names the file and the line of a position."""
        line = self.text.count("\n", 0, position) + 1
        return SinewError(f"{self.name}, line {line}: {what}")

    def table(self) -> Table:
        """The object that the whole text is."""
        if self.text.count(",") >= MAX_VALUES:
            raise self.error(len(self.text), f"more than {MAX_VALUES} values; no more can be read")
        begin = self._after_space(0)
        if self.text[begin : begin + 1] != "{":
            self._end_of(begin)
            raise self.error(begin, f"must be an object in braces, not {_shown(self.value_at(begin, ''))}")
        table = Table(self, begin)
        table.fields()
        end = self._after_space(table.end)
        if end < len(self.text):
            raise self._not_json(end, "text after the last brace")
        return table

    def fields_at(self, begin: int) -> tuple[list[tuple[str, int, int]], int]:
        """The name of each field of an object, with the positions of name and value; and the position after the object."""
        fields: list[tuple[str, int, int]] = []
        at = first = self._after_space(begin + 1)
        while self.text[at : at + 1] != "}":
            if at != first:
                at = self._after(at, ",")
            name_at = at
            if len(fields) == MAX_FIELDS:
                raise self.error(at, f"an object has more than {MAX_FIELDS} fields; no more can be read")
            if self.text[at : at + 1] != '"':
                raise self._not_json(at, "the name of a field in quotes is expected")
            field, at = self._string(at)
            value_at = self._after(self._after_space(at), ":")
            fields.append((field, name_at, value_at))
            at = self._after_space(self._end_of(value_at))
        return fields, at + 1

    def entries_at(self, begin: int, field: str) -> Iterator[int]:
        """The positions of the entries of a list."""
        at = first = self._after_space(begin + 1)
        count = 0
        while self.text[at : at + 1] != "]":
            if at != first:
                at = self._after(at, ",")
            count += 1
            if count > MAX_ENTRIES:
                raise self.error(at, f"'{_shortened(field)}' has more than {MAX_ENTRIES} entries; no more can be read")
            yield at
            at = self._after_space(self._end_of(at))

    def value_at(self, begin: int, field: str, depth: int = 0) -> Any:
        """The value at a position: a Table, a list, a text, a number, a constant.

        field: the field that it belongs to. depth: the number of lists around it.
        """
        first = self.text[begin : begin + 1]
        if first == '"':
            return self._string(begin)[0]
        if first == "{":
            return Table(self, begin)
        if first == "[":
            if depth == MAX_DEPTH:
                raise self._too_deep(begin)
            return [self.value_at(at, field, depth + 1) for at in self.entries_at(begin, field)]
        word, constant = _CONSTANTS.get(first, ("", None))
        if word and self.text.startswith(word, begin):
            return constant
        return self._number(begin, field)

    def _end_of(self, begin: int) -> int:
        """The position after a value, which is not parsed. Raises SinewError where it is not JSON."""
        collects = gc.isenabled()
        gc.disable()  # it would look at each of many thousand values again and again, though none is kept
        try:
            return _skip(self.text, begin)[1]
        except StopIteration as error:
            raise self._not_json(error.value, "a value is expected") from error
        except json.JSONDecodeError as error:
            raise self._not_json(error.pos, error.msg) from error
        except RecursionError as error:
            raise self._too_deep(begin) from error
        finally:
            if collects:
                gc.enable()

    def _too_deep(self, position: int) -> SinewError:
        return self.error(position, f"more than {MAX_DEPTH} objects and lists inside each other")

    def _string(self, begin: int) -> tuple[str, int]:
        try:
            text, end = scanstring(self.text, begin + 1, True)
        except json.JSONDecodeError as error:
            raise self._not_json(error.pos, error.msg) from error
        if _LONE_SURROGATE.search(text):
            raise self._not_json(begin, "half of a surrogate pair")
        return text, end

    def _number(self, begin: int, field: str) -> int | float:
        match = _NUMBER.match(self.text, begin)
        if match is None:
            refused = _NOT_A_NUMBER.match(self.text, begin)
            if refused:
                raise self.error(begin, f"'{_shortened(field)}' has {refused[0]}, which is not a number")
            raise self._not_json(begin, "a value is expected")
        is_integer = not (match[1] or match[2]) and len(match[0]) <= _LONGEST_EXACT_INTEGER
        number = int(match[0]) if is_integer else float(match[0])
        if not math.isfinite(number):
            raise self.error(begin, f"'{_shortened(field)}' has {_shortened(match[0])}, which is too large a number")
        return number

    def _after(self, at: int, mark: str) -> int:
        """The next position that is not white space, after a mark. Raises SinewError if the mark is not at `at`."""
        if self.text[at : at + 1] != mark:
            raise self._not_json(at, f"'{mark}' is expected")
        return self._after_space(at + 1)

    def _after_space(self, at: int) -> int:
        return _SPACE.match(self.text, at).end()

    def _not_json(self, position: int, what: str) -> SinewError:
        return self.error(position, f"not JSON ({what})")


def _shown_name(path: Path) -> str:
    """The name of a file, for messages. A name that is not UTF-8 has lone surrogates in Python."""
    return path.name.encode("utf-8", "backslashreplace").decode()


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)


def _shown(value: Any) -> str:
    if isinstance(value, Table):
        return "an object"
    if isinstance(value, list):
        value = value[:_LONGEST_SHOWN]
    return _shortened(json.dumps(value, default=lambda _: "{...}"))


def _shortened(text: str) -> str:
    return text if len(text) <= _LONGEST_SHOWN else f"{text[: _LONGEST_SHOWN - 3]}..."
