"""scripts/test.py: which suites run, their order, and the exit code."""

import importlib.util
import sys

import pytest
from build.console import Failure, Missing, PythonMissing
from build.layout import SCRIPTS


@pytest.fixture
def module(monkeypatch):
    """scripts/test.py. It is loaded from its path, because Python has a package `test`."""
    spec = importlib.util.spec_from_file_location("test_of_everything", SCRIPTS / "test.py")
    module = importlib.util.module_from_spec(spec)
    monkeypatch.setitem(sys.modules, spec.name, module)  # dataclasses look there
    spec.loader.exec_module(module)
    return module


def names(module, *versions, slow=False):
    return [suite.name for suite in module.suites(list(versions), slow)]


def test_every_blender_has_its_suites(module):
    both = names(module, "5.2", "4.5")
    assert set(both) == {
        "cargo fmt", "cargo clippy", "cargo test", "cargo doc", "binding, Python 3.13", "binding, Python 3.11", "scripts",
        "farms", "window", "extension, Blender 5.2", "extension, Blender 4.5", "ruff check", "ruff format", "mypy",
        "architecture picture",
    }  # fmt: skip
    assert len(both) == len(set(both))
    assert set(both) - set(names(module, "4.5")) == {"binding, Python 3.13", "extension, Blender 5.2"}
    assert set(names(module, "5.2", "4.5", slow=True)) - set(both) == {"cargo deny", "cargo mutants"}


@pytest.mark.parametrize("name", ["cargo deny", "cargo mutants"])
def test_a_cargo_plugin_that_is_not_installed_is_missing(module, monkeypatch, capsys, tmp_path, name):
    monkeypatch.setenv("PATH", str(tmp_path))
    suite = next(suite for suite in module.suites([], True) if suite.name == name)
    assert module.run_alone(suite) == "MISSING"
    assert f"cargo install --locked {name.replace(' ', '-')}" in capsys.readouterr().err


def test_the_first_suite_after_cargo_builds_the_wheel_and_the_longest_follow(module):
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
        (raising(Missing("no cargo-deny")), "MISSING", "no cargo-deny"),
    ],
)
def test_result_of_a_suite(module, holds, result, words, capsys):
    assert module.run_alone(module.Suite("rust", "a suite", holds)) == result
    printed = capsys.readouterr().err
    assert words in printed and f"a suite: {result} in " in printed


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
def test_every_result_counts(module, monkeypatch, capsys, codes, ci, code, words):
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


def test_an_unknown_suite_is_an_error(module, monkeypatch, capsys):
    monkeypatch.setattr("sys.argv", ["test.py", "--suite", "none"])
    with pytest.raises(SystemExit) as ending:
        module.main()
    assert ending.value.code == 2 and "no suite none" in capsys.readouterr().err
