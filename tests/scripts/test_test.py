"""scripts/test.py: what runs, in which order, and what the exit code says."""

import importlib.util
import sys

import pytest
from build.console import Failure, PythonMissing
from build.layout import SCRIPTS


@pytest.fixture
def module(monkeypatch):
    """scripts/test.py; Python has a package of that name."""
    spec = importlib.util.spec_from_file_location("test_of_everything", SCRIPTS / "test.py")
    module = importlib.util.module_from_spec(spec)
    monkeypatch.setitem(sys.modules, spec.name, module)  # dataclasses look there
    spec.loader.exec_module(module)
    return module


def names(module, *versions):
    return [suite.name for suite in module.suites(list(versions), False)]


def test_every_blender_has_its_suites(module):
    both = names(module, "5.2", "4.5")
    assert set(both) == {
        "cargo fmt", "cargo clippy", "cargo test", "cargo doc", "binding, Python 3.13", "binding, Python 3.11", "scripts",
        "farms", "extension, Blender 5.2", "extension, Blender 4.5",
    }  # fmt: skip
    assert len(both) == len(set(both))
    assert set(both) - set(names(module, "4.5")) == {"binding, Python 3.13", "extension, Blender 5.2"}


def test_the_wheel_is_built_beside_cargos_suites_and_the_longest_follow(module):
    others = [name for name in names(module, "5.2", "4.5") if not name.startswith("cargo")]
    assert others[0].startswith("binding") and all(name.startswith("extension") for name in others[1:3])


def raising(error):
    def holds():
        raise error

    return holds


@pytest.mark.parametrize(
    ("holds", "result", "words"),
    [
        (lambda: True, "passed", ""),
        (lambda: False, "FAILED", ""),
        (raising(Failure("no cargo")), "FAILED", "no cargo"),
        (raising(PythonMissing("no 3.11")), "MISSING", "CANNOT BE TESTED HERE"),
    ],
)
def test_what_a_suite_comes_to(module, holds, result, words, capsys):
    assert module.run_alone(module.Suite("rust", "a suite", holds)) == result
    said = capsys.readouterr().err
    assert words in said and f"a suite: {result} in " in said


@pytest.mark.parametrize(
    ("codes", "ci", "code", "words"),
    [
        ((0, 0), False, 0, "passed"),
        ((0, 1), False, 1, "FAILED"),
        ((-9, 0), False, 1, "FAILED"),
        ((0, 3), False, 0, "BUT NOT EVERYTHING WAS TESTED"),
        ((0, 3), True, 1, "FAILED"),
    ],
)
def test_all_that_was_found_counts(module, monkeypatch, capsys, codes, ci, code, words):
    def run(commands, _at_once):
        for command, ended in zip(commands, codes, strict=True):
            yield module.side_by_side.Ended(command, ended, f"printed by {command.name}", 1.0)

    monkeypatch.setattr(module.side_by_side, "run", run)
    monkeypatch.setattr("sys.argv", ["test.py", "--only", "binding"])
    monkeypatch.setenv("CI", "1") if ci else monkeypatch.delenv("CI", raising=False)
    assert module.main() == code
    out = capsys.readouterr().out
    assert "printed by binding, Python 3.13" in out and "printed by binding, Python 3.11" in out
    assert words in out.splitlines()[-1]


def test_an_unknown_suite_is_said_to_be(module, monkeypatch, capsys):
    monkeypatch.setattr("sys.argv", ["test.py", "--suite", "none"])
    with pytest.raises(SystemExit) as ending:
        module.main()
    assert ending.value.code == 2 and "no suite none" in capsys.readouterr().err
