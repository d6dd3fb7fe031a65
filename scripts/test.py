"""Builds and tests everything: style, the Rust core, its Python binding, the scripts, and the extension in every Blender.

usage: python3 scripts/test.py [--only style|rust|binding|scripts|blender] [--blender 5.2|4.5] [--slow] [--at-once N]

Most suites use one processor, so as many suites run at a time as there are processors (or --at-once). Each runs in its own
process, `test.py --suite NAME`, and its output is printed when it ends. The last lines give the result of each suite and of
all; the exit code is 0 only if nothing failed. If a suite needs a Python or a tool that is not installed and cannot be
fetched, its result is MISSING, which counts as a failure if the environment variable CI is set. --slow adds tests marked
slow (pytest) or ignored (cargo), cargo-deny and cargo-mutants.
"""

import argparse
import datetime
import os
import shutil
import subprocess
import sys
import time
import zipfile
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

from build import blender, environment
from build import wheel as build_wheel
from build.build_lock import building, fingerprint
from build.console import Failure, Missing, PythonMissing, say
from build.layout import BUILD, ROOT, SCRIPTS
from testing import side_by_side

PASSED, FAILED, MISSING = "passed", "FAILED", "MISSING"
EXIT_CODES = {PASSED: 0, FAILED: 1, MISSING: 3}  # of one suite; Python exits with 2 for wrong arguments
GROUPS = ("style", "rust", "binding", "scripts", "blender")
MUTANT_SHARDS = 40


@dataclass(frozen=True)
class Suite:
    """A named check. `holds` returns whether it passed, or raises Failure."""

    group: str
    name: str
    holds: Callable[[], bool]


def suites(versions: list[str], slow: bool) -> list[Suite]:
    """All suites in the order in which to start them.

    The cargo suites run one at a time and form the longest chain. The first of the other suites builds the wheel meanwhile.
    The longest suites follow, so that the short ones fill the end.
    """
    binding = [_binding(version, slow) for version in versions]
    in_blender = [_in_blender(version, slow) for version in versions]
    scripts = [
        Suite("scripts", "scripts", lambda: test_scripts("tests/scripts", versions, slow)),
        Suite("scripts", "farms", lambda: test_scripts("tests/farm", versions, slow)),
        Suite("scripts", "window", lambda: test_scripts("tests/installed", versions, slow)),
    ]
    return [*_rust(slow), *binding[:1], *in_blender, *scripts, *_style(), *binding[1:]]


def _style() -> list[Suite]:
    return [
        Suite("style", "ruff check", lambda: checked("ruff", "check")),
        Suite("style", "ruff format", lambda: checked("ruff", "format", "--check")),
        Suite("style", "mypy", lambda: checked("mypy")),
        Suite(
            "style", "architecture picture",
            lambda: succeeds([sys.executable, SCRIPTS / "architecture_picture.py", "--check"], {}),
        ),
    ]  # fmt: skip


def _rust(slow: bool) -> list[Suite]:
    ignored = ["--", "--include-ignored"] if slow else []
    every = ["--workspace", "--locked"]
    suites = [
        Suite("rust", "cargo fmt", lambda: cargo("fmt", "--all", "--check")),
        Suite("rust", "cargo clippy", lambda: cargo("clippy", *every, "--all-targets", "--", "-D", "warnings")),
        Suite("rust", "cargo test", lambda: cargo("test", *every, *ignored)),
        Suite("rust", "cargo doc", lambda: cargo("doc", *every, "--no-deps", RUSTDOCFLAGS="-D warnings")),
    ]
    if slow:
        suites += [
            Suite("rust", "cargo deny", lambda: cargo_plugin("deny", "check", "licenses", "bans", "sources")),
            Suite("rust", "cargo mutants", mutants),
        ]
    return suites


def _binding(version: str, slow: bool) -> Suite:
    return Suite("binding", f"binding, Python {environment.PYTHON_OF_BLENDER[version]}", lambda: test_binding(version, slow))


def _in_blender(version: str, slow: bool) -> Suite:
    return Suite("blender", f"extension, Blender {version}", lambda: test_in_blender(version, slow))


def checked(tool: str, *arguments: str) -> bool:
    """Runs a tool of the `style` environment, whose versions are pinned, on the whole repository."""
    return succeeds([environment.program(environment.style(), tool), *arguments], {})


def cargo(*arguments: str, **env: str) -> bool:
    if shutil.which("cargo") is None:
        raise Failure(build_wheel.RUST_MISSING)
    return succeeds(["cargo", *arguments], env)


def cargo_plugin(name: str, *arguments: str) -> bool:
    """Runs a command of cargo that has to be installed separately."""
    if shutil.which(f"cargo-{name}") is None:
        raise Missing(f"cargo-{name} is not installed. Install it with: cargo install --locked cargo-{name}")
    return cargo(name, *arguments)


def mutants() -> bool:
    """Tests this week's share of the mutants; .cargo/mutants.toml says which files are mutated, and how they are tested.

    All mutants would take days, so the mutants are split into shards, and the shard changes every week.
    """
    week = (datetime.date.today() - datetime.date(2024, 1, 1)).days // 7
    (BUILD / "mutants").mkdir(parents=True, exist_ok=True)
    return cargo_plugin(
        "mutants", "--package", "sinew-core", "--shard", f"{week % MUTANT_SHARDS}/{MUTANT_SHARDS}", "--no-times",
        "--output", str(BUILD / "mutants"),
    )  # fmt: skip


def test_binding(version: str, slow: bool) -> bool:
    """Runs tests/core with the Python of this Blender and the oldest or newest numpy that Sinew supports, without bpy."""
    python = environment.blender(version)
    return succeeds([python, "-m", "pytest", *pytest_options("tests/core", slow)], {"PYTHONPATH": str(unpacked_wheel())})


def test_scripts(folder: str, versions: list[str], slow: bool) -> bool:
    """Runs a folder of tests with the Python of the first Blender available. The tests run scripts in every Blender."""
    pythons = []
    for version in versions:  # made here, because the tests skip a Blender that is not there
        with suppress(PythonMissing):  # reported by the suites of that Blender
            pythons.append(environment.blender(version))
    if not pythons:
        raise PythonMissing(f"no Python for Blender {' or '.join(versions)}")
    return succeeds([pythons[0], "-m", "pytest", *pytest_options(folder, slow)], {})


def test_in_blender(version: str, slow: bool) -> bool:
    """Runs tests/blender. Tests marked one_blender run in the newest Blender only, unless all slow tests run."""
    os.chdir(ROOT)
    without = "" if slow or version == environment.BLENDERS[0] else "one_blender"
    options = pytest_options("tests/blender", slow, without)
    return blender.run(version, SCRIPTS / "testing/pytest_in_blender.py", options) == 0


MARKS = """
slow: takes long, and runs only with test.py --slow
one_blender: asks nothing of Blender that differs between its versions, and runs in the newest only
"""


def pytest_options(folder: str, slow: bool, without: str = "") -> list[str]:
    """The arguments of pytest. without: a further mark of tests that do not run, besides `slow`."""
    left_out = [mark for mark in ("" if slow else "slow", without) if mark]
    chosen = ["-m", " and ".join(f"not {mark}" for mark in left_out)] if left_out else []
    marks = ["--strict-markers", "-o", f"markers={MARKS}"]
    return [folder, "-q", "-ra", "--durations=3", "--rootdir", str(ROOT), "-p", "no:cacheprovider", *marks, *chosen]


def unpacked_wheel() -> Path:
    """The folder of the unpacked wheel. On PYTHONPATH, it acts as the installed wheel."""
    with building():
        wheel = build_wheel.build()
        folder = BUILD / "unpacked" / fingerprint(BUILD, [wheel])
        if not folder.is_dir():
            shutil.rmtree(folder.parent, ignore_errors=True)
            with zipfile.ZipFile(wheel) as archive:
                archive.extractall(folder)
        return folder


def succeeds(command: list[str | Path], env: dict[str, str]) -> bool:
    return subprocess.run(list(map(str, command)), cwd=ROOT, env=os.environ | env).returncode == 0


def result_of(suite: Suite) -> str:
    try:
        return PASSED if suite.holds() else FAILED
    except Missing as error:
        say(f"{'!' * 20} {suite.name} CANNOT BE TESTED HERE {'!' * 20}\n{error}")
        return MISSING
    except Failure as error:
        say(f"{suite.name}: {error}")
        return FAILED


def run_alone(suite: Suite) -> str:
    """Runs a suite in this process and prints its result, its seconds and its processor seconds."""
    say(f"----- {suite.name}")
    start = time.perf_counter()
    result = result_of(suite)
    spent = os.times()
    processors = spent.user + spent.system + spent.children_user + spent.children_system
    say(f"{suite.name}: {result} in {time.perf_counter() - start:.1f} s, {processors:.1f} s of processors")
    return result


def run_side_by_side(chosen: list[Suite], options: list[str], at_once: int) -> dict[str, tuple[str, float]]:
    """Runs each suite in its own process; returns result and seconds by the suite's name."""
    commands = [
        side_by_side.Command(
            suite.name, [sys.executable, SCRIPTS / "test.py", "--suite", suite.name, *options], ROOT,
            one_of="cargo" if suite.group == "rust" else None,  # cargo locks its target folder
        )
        for suite in chosen
    ]  # fmt: skip
    results = {}
    for ended in side_by_side.run(commands, at_once):
        print(ended.output, flush=True)
        result = next((result for result, code in EXIT_CODES.items() if code == ended.code), FAILED)
        results[ended.command.name] = result, ended.seconds
        left = len(chosen) - len(results)
        say(f"{ended.command.name} {result} after {ended.seconds:.1f} s; {left or 'no'} more to come")
    return results


def main() -> int:
    parser = argparse.ArgumentParser(description="Builds and tests everything.")
    parser.add_argument("--only", choices=GROUPS)
    parser.add_argument("--blender", choices=environment.BLENDERS, help="test only this version, and its Python")
    parser.add_argument("--slow", action="store_true", help="run the slow tests, too")
    parser.add_argument("--at-once", type=int, default=os.cpu_count() or 1, metavar="N", help="suites that run at a time")
    parser.add_argument(
        "--suite",
        metavar="NAME",
        help=f"run only this suite, in this process; exit code {EXIT_CODES[MISSING]} means MISSING",
    )
    wanted = parser.parse_args()

    start = time.perf_counter()
    versions = [wanted.blender] if wanted.blender else list(environment.BLENDERS)
    chosen = [
        suite for suite in suites(versions, wanted.slow)
        if wanted.only in (None, suite.group) and wanted.suite in (None, suite.name)
    ]  # fmt: skip
    if not chosen:
        parser.error(f"there is no suite {wanted.suite}")
    if wanted.suite:
        return EXIT_CODES[run_alone(chosen[0])]
    options = [*(["--blender", wanted.blender] if wanted.blender else []), *(["--slow"] if wanted.slow else [])]
    results = run_side_by_side(chosen, options, max(wanted.at_once, 1))

    kinds = {result for result, _ in results.values()}
    lines = [f"{suite.name:<24} {results[suite.name][0]:<8} {results[suite.name][1]:6.1f} s" for suite in chosen]
    bad = {FAILED, MISSING} if os.environ.get("CI") else {FAILED}
    overall = FAILED if kinds & bad else f"{PASSED}, BUT NOT EVERYTHING WAS TESTED" if MISSING in kinds else PASSED
    print("\n" + "\n".join(lines), f"\n{'all':<24} {overall:<8} {time.perf_counter() - start:6.1f} s", sep="", flush=True)
    return 0 if overall != FAILED else 1


if __name__ == "__main__":
    try:
        sys.exit(main())
    except KeyboardInterrupt:
        sys.exit(130)
