"""Commands side by side: how many at a time, in which order, and that none outlives what ended the others."""

import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from testing import side_by_side
from testing.side_by_side import Command

SCRIPTS = Path(side_by_side.__file__).parents[1]
SAY_WHEN = "import sys, time; start = time.time(); time.sleep({seconds}); print(start, time.time()); sys.exit({code})"


def saying_when(name, folder, seconds=0.3, code=0, **options):
    return Command(name, [sys.executable, "-c", SAY_WHEN.format(seconds=seconds, code=code)], folder, **options)


def spans(ended):
    return {one.command.name: tuple(map(float, one.output.split())) for one in ended}


def overlap(one, other):
    return max(one[0], other[0]) < min(one[1], other[1])


def test_as_many_run_as_are_allowed_and_each_ends_with_its_own_code(tmp_path):
    ended = list(side_by_side.run([saying_when(str(code), tmp_path, 1.5, code) for code in range(3)], 2))
    assert {one.command.name: one.code for one in ended} == {"0": 0, "1": 1, "2": 2}
    found = spans(ended)
    assert overlap(found["0"], found["1"])
    assert found["2"][0] > min(found["0"][1], found["1"][1])


def test_one_at_a_time_keeps_the_order(tmp_path):
    ended = list(side_by_side.run([saying_when(name, tmp_path, 0.0) for name in "abc"], 1))
    assert [one.command.name for one in ended] == ["a", "b", "c"]


def test_of_one_kind_one_runs_and_others_pass_it(tmp_path):
    kind = {"one_of": "cargo"}
    commands = [saying_when("a", tmp_path, 0.6, **kind), saying_when("b", tmp_path, **kind), saying_when("c", tmp_path, 1.0)]
    found = spans(side_by_side.run(commands, 2))
    assert not overlap(found["a"], found["b"])
    assert found["c"][0] < found["b"][0]


def test_both_streams_are_shown(tmp_path):
    words = [sys.executable, "-c", "import sys; print('out', flush=True); print('err', file=sys.stderr)"]
    (ended,) = side_by_side.run([Command("both", words, tmp_path)], 1)
    assert ended.output.split() == ["out", "err"]


RUNNER = '''
import signal, sys
signal.signal(signal.SIGINT, signal.default_int_handler)  # a shell's background jobs inherit that it is ignored
sys.path.insert(0, sys.argv[1])
from testing import side_by_side
from pathlib import Path

child = """import os, subprocess, sys, time
open(sys.argv[1], 'w').write(str(os.getpid()))
print('printed by', os.getpid(), flush=True)
subprocess.Popen(['sleep', '300'])
time.sleep(300)
"""
commands = [side_by_side.Command(name, [sys.executable, "-c", child, name], Path.cwd()) for name in ("a", "b")]
try:
    for _ in side_by_side.run(commands, 2):
        pass
except KeyboardInterrupt:
    sys.exit(130)
'''


@pytest.mark.skipif(not Path("/proc").is_dir(), reason="only here is it known what a process has started")
@pytest.mark.parametrize("ending", [signal.SIGINT, signal.SIGTERM])
def test_what_ends_it_ends_all_that_was_started(tmp_path, ending):
    process = subprocess.Popen([sys.executable, "-c", RUNNER, str(SCRIPTS)], cwd=tmp_path, stdout=subprocess.PIPE, text=True)
    groups = [wait_for_number(tmp_path / name) for name in ("a", "b")]
    wait_until(lambda: all(len(members(group)) == 2 for group in groups))
    process.send_signal(ending)
    out, _ = process.communicate(timeout=60)
    assert process.returncode == 130
    assert all(f"{name} was ended" in out and f"printed by {group}" in out for name, group in zip("ab", groups, strict=True))
    wait_until(lambda: not any(members(group) for group in groups))


def wait_until(holds):
    for _ in range(600):
        if holds():
            return
        time.sleep(0.1)
    raise AssertionError("did not happen in a minute")


def wait_for_number(file):
    wait_until(lambda: file.is_file() and file.read_text())
    return int(file.read_text())


def members(group):
    """The processes of a group that have not ended."""
    found = []
    for entry in Path("/proc").iterdir():
        if entry.name.isdigit():
            try:
                state, _parent, of = (entry / "stat").read_text().rpartition(")")[2].split()[:3]
            except (FileNotFoundError, ProcessLookupError):
                continue
            if int(of) == group and state != "Z":
                found.append(entry.name)
    return found
