# SPDX-License-Identifier: GPL-3.0-or-later
"""Reading a stranger's JSON: as data, field by field, with the file, line and field of whatever is wrong."""

import json
import math
import re
from bisect import bisect_right
from json.decoder import JSONObject
from json.scanner import py_make_scanner
from pathlib import Path
from typing import Any

from ..errors import SinewError

LARGEST_FILE_BYTES = 8_000_000
MISSING = object()


class Table:
    """A JSON object that knows where it stands; `finish` finds the fields that nothing read."""

    def __init__(self, fields: dict[str, Any], source: "_Source", start: int, end: int) -> None:
        self._fields = fields
        self._source, self._start, self._end = source, start, end
        self._read: set[str] = set()

    def fault(self, field: str, what: str) -> SinewError:
        """An error that names the file, the line and the field."""
        found = re.compile(re.escape(json.dumps(field)) + r"\s*:").search(self._source.text, self._start, self._end)
        line = self._source.line(found.start() if found else self._start)
        return SinewError(f"{self._source.name}, line {line}: '{field}' {what}")

    def get(self, field: str, default: Any = MISSING) -> Any:
        self._read.add(field)
        value = self._fields.get(field, default)
        if value is MISSING:
            raise self.fault(field, "is missing")
        return value

    def has(self, field: str) -> bool:
        return field in self._fields

    def table(self, field: str) -> "Table":
        value = self.get(field)
        if not isinstance(value, Table):
            raise self.fault(field, f"must be an object in braces, not {_shown(value)}")
        return value

    def tables(self, field: str, most: int) -> list["Table"]:
        value = self.get(field)
        if not isinstance(value, list) or not all(isinstance(entry, Table) for entry in value):
            raise self.fault(field, f"must be a list of objects in braces, not {_shown(value)}")
        if len(value) > most:
            raise self.fault(field, f"has {len(value)} entries; at most {most} can be read")
        return value

    def text(self, field: str, longest_bytes: int = 63) -> str:
        value = self.get(field)
        if not isinstance(value, str) or not value.strip() or not value.isprintable():
            raise self.fault(field, f"must be a text, not {_shown(value)}")
        if len(value.encode()) > longest_bytes:
            raise self.fault(field, f"is longer than {longest_bytes} bytes: {_shown(value)}")
        return value

    def texts(self, field: str) -> tuple[str, ...]:
        value = self.get(field)
        if not isinstance(value, list) or not all(isinstance(entry, str) and entry for entry in value):
            raise self.fault(field, f"must be a list of texts, not {_shown(value)}")
        return tuple(value)

    def one_of(self, field: str, known: tuple[str, ...]) -> str:
        value = self.get(field)
        if not isinstance(value, str) or value not in known:
            raise self.fault(field, f"must be one of {', '.join(known)}, not {_shown(value)}")
        return value

    def flag(self, field: str) -> bool:
        value = self.get(field)
        if not isinstance(value, bool):
            raise self.fault(field, f"must be true or false, not {_shown(value)}")
        return value

    def number(self, field: str, low: float, high: float) -> float:
        value = self.get(field)
        if not _is_number(value) or not low <= value <= high:
            raise self.fault(field, f"must be a number from {low:g} to {high:g}, not {_shown(value)}")
        return float(value)

    def numbers(self, field: str, count: int, low: float, high: float) -> tuple[float, ...]:
        value = self.get(field)
        if not isinstance(value, list) or len(value) != count or not all(map(_is_number, value)):
            raise self.fault(field, f"must be a list of {count} numbers, not {_shown(value)}")
        if not all(low <= entry <= high for entry in value):
            raise self.fault(field, f"must have numbers from {low:g} to {high:g}, not {_shown(value)}")
        return tuple(map(float, value))

    def finish(self) -> None:
        """Raises SinewError where a field is left that nothing knows."""
        unknown = sorted(set(self._fields) - self._read)
        if unknown:
            raise self.fault(unknown[0], "is not a field that Sinew knows here")


def read(path: Path) -> Table:
    """The object that a file holds. Raises SinewError, naming file and line."""
    try:
        if path.stat().st_size > LARGEST_FILE_BYTES:
            raise SinewError(f"{path.name}: more than {LARGEST_FILE_BYTES // 1_000_000} MB is no file of Sinew's")
        source = _Source(path.name, path.read_text(encoding="utf-8"))
        found = _Decoder(source).decode(source.text)
    except OSError as error:
        raise SinewError(f"{path.name}: can't be read ({error.strerror}): choose another file") from error
    except json.JSONDecodeError as error:
        raise SinewError(f"{path.name}, line {error.lineno}: not JSON ({error.msg})") from error
    except (ValueError, RecursionError) as error:
        raise SinewError(f"{path.name}: not a JSON file in UTF-8 ({error})") from error
    if not isinstance(found, Table):
        raise SinewError(f"{path.name}, line 1: must be an object in braces, not {_shown(found)}")
    return found


class _Source:
    def __init__(self, name: str, text: str) -> None:
        self.name, self.text = name, text
        self._line_ends = [place.start() for place in re.finditer("\n", text)]

    def line(self, place: int) -> int:
        return bisect_right(self._line_ends, place) + 1


class _Decoder(json.JSONDecoder):
    """JSON whose objects are tables."""

    def __init__(self, source: _Source) -> None:
        super().__init__(object_pairs_hook=list)
        self._source = source
        self.parse_object = self._object
        self.scan_once = py_make_scanner(self)  # the one in C asks nobody where an object begins

    def _object(self, text_and_end, *rest):
        pairs, end = JSONObject(text_and_end, *rest)
        table = Table(dict(pairs), self._source, text_and_end[1], end)
        names = [name for name, _ in pairs]
        twin = next((name for name in names if names.count(name) > 1), None)
        if twin is not None:
            raise table.fault(twin, "stands twice in one object")
        return table, end


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and math.isfinite(value)


def _shown(value: Any) -> str:
    if isinstance(value, Table):
        return "an object"
    text = json.dumps(value, default=lambda _: "{...}")
    return text if len(text) <= 40 else f"{text[:37]}..."
