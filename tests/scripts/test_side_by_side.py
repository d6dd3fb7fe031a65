"""Commands side by side: their number at a time, their order, and that an early end ends all of them."""

import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from testing import side_by_side
from testing.side_by_side import Command

SCRIPTS = Path(side_by_side.__file__).parents[1]
PRINT_TIMES = "import sys, time; start = time.time(); time.sleep({seconds}); print(start, time.time()); sys.exit({code})"


def printing_times(name, folder, seconds=0.3, code=0, **options):
    return Command(name, [sys.executable, "-c", PRINT_TIMES.format(seconds=seconds, code=code)], folder, **options)


def spans(ended):
    return {one.command.name: tuple(map(float, one.output.split())) for one in ended}


def overlap(one, other):
    return max(one[0], other[0]) < min(one[1], other[1])


def test_at_most_the_allowed_number_runs_and_each_exit_code_is_kept(tmp_path):
    ended = list(side_by_side.run([printing_times(str(code), tmp_path, 1.5, code) for code in range(3)], 2))
    assert {one.command.name: one.code for one in ended} == {"0": 0, "1": 1, "2": 2}
    times = spans(ended)
    assert overlap(times["0"], times["1"])
    assert times["2"][0] > min(times["0"][1], times["1"][1])


def test_one_at_a_time_keeps_the_order(tmp_path):
    ended = list(side_by_side.run([printing_times(name, tmp_path, 0.0) for name in "abc"], 1))
    assert [one.command.name for one in ended] == ["a", "b", "c"]


def test_commands_with_the_same_one_of_run_one_at_a_time_and_others_overtake_them(tmp_path):
    cargo = {"one_of": "cargo"}
    commands = [
        printing_times("a", tmp_path, 0.6, **cargo),
        printing_times("b", tmp_path, **cargo),
        printing_times("c", tmp_path, 1.0),
    ]
    times = spans(side_by_side.run(commands, 2))
    assert not overlap(times["a"], times["b"])
    assert times["c"][0] < times["b"][0]


def test_both_streams_are_shown(tmp_path):
    words = [sys.executable, "-c", "import sys; print('out', flush=True); print('err', file=sys.stderr)"]
    (ended,) = side_by_side.run([Command("both", words, tmp_path)], 1)
    assert ended.output.split() == ["out", "err"]


RUNNER = '''
import signal, sys
signal.signal(signal.SIGINT, signal.default_int_handler)  # background jobs of a shell inherit an ignored SIGINT
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


@pytest.mark.skipif(not Path("/proc").is_dir(), reason="/proc is needed to list the processes of a group")
@pytest.mark.parametrize("ending", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_ends_all_commands_and_their_processes(tmp_path, ending):
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
    alive = []
    for entry in Path("/proc").iterdir():
        if entry.name.isdigit():
            try:
                state, _parent, its_group = (entry / "stat").read_text().rpartition(")")[2].split()[:3]
            except (FileNotFoundError, ProcessLookupError):
                continue
            if int(its_group) == group and state != "Z":
                alive.append(entry.name)
    return alive
