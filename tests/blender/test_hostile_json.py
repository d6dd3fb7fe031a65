# SPDX-License-Identifier: GPL-3.0-or-later
"""Files of strangers are refused within 0.1 s, with their line, whatever they hold: presets, musculatures and records."""

import os
import time

import pytest
from bl_ext.user_default.sinew.errors import SinewError
from bl_ext.user_default.sinew.files import strict_json

pytestmark = pytest.mark.one_blender

REFUSED_S = 0.1
MOST = strict_json.MAX_VALUES - 1000

HOSTILE = {
    "numbers": '{"a": [' + "1," * MOST + "1]}",
    "more values than can be read": '{"a": [' + "1," * (4 * MOST) + "1]}",
    "lists": '{"a": [' + "[]," * MOST + "[]]}",
    "objects": '{"a": [' + "{}," * MOST + "{}]}",
    "fields": "{" + ",".join(f'"{index}":1' for index in range(MOST)) + "}",
    "one name many times": "{" + ",".join(['"a":1'] * MOST) + "}",
    "not a number, late": '{"a": [' + "1," * MOST + "NaN]}",
    "not a number, deep": '{"a": [' * 500 + "1," * MOST + "NaN",
    "not JSON, late": '{"a": [' + "1," * MOST + "x]}",
    "depth": '{"a":' * 1_000_000,
    "depth of lists": '{"a":' + "[" * 5_000_000,
    "a long number": '{"a":' + "9" * 7_000_000 + "}",
    "a long fraction": '{"a":0.' + "9" * 7_000_000 + "}",
    "a large exponent": '{"a":1e' + "9" * 7_000_000 + "}",
    "a long text": '{"a":"' + "x" * 7_900_000 + '"}',
    "a long name": '{"' + "x" * 7_900_000 + '":1}',
    "escapes": '{"a":"' + "\\u0041" * 1_300_000 + '"}',
    "spaces": "{" + " " * 7_900_000,
    "lines": "{" + "\n" * 7_900_000 + "x",
    "half a text": '{"a":"' + "x" * 7_900_000,
}


def refused(path):
    """Reads a file as one with a number "a" of 0 to 1. Returns the message and the CPU time in s, the least of three."""
    seconds = []
    for _ in range(3):
        begin = time.process_time()
        with pytest.raises(SinewError) as caught:
            table = strict_json.read(path)
            table.number("a", 0.0, 1.0)
            table.finish()
            raise SinewError("accepted")
        seconds.append(time.process_time() - begin)
    return str(caught.value), min(seconds)


@pytest.mark.parametrize("kind", HOSTILE)
def test_a_hostile_file_is_refused_in_time_with_its_line(tmp_path, kind):
    path = tmp_path / "a.json"
    path.write_text(HOSTILE[kind])
    message, seconds = refused(path)
    if kind == "a long fraction":  # it is a number from 0 to 1
        assert message == "accepted"
    else:
        assert message.startswith("a.json, line ") and len(message) < 200
    assert seconds < REFUSED_S


@pytest.mark.skipif(os.name == "nt", reason="Windows has neither")
def test_devices_and_pipes_are_refused(tmp_path):
    os.mkfifo(tmp_path / "pipe.json")
    for path in (tmp_path / "pipe.json", tmp_path):
        assert "not a file with text" in refused(path)[0]
    os.symlink("/dev/zero", tmp_path / "zero.json")
    assert "not a file with text" in refused(tmp_path / "zero.json")[0]
