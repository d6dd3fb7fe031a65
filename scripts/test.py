"""Builds and tests everything: the Rust core, its Python binding, the scripts, and the extension in every Blender.

usage: python3 scripts/test.py [--only rust|binding|scripts|blender] [--blender 5.2|4.5] [--slow] [--at-once N]

Most suites keep one processor busy, so as many run at once as there are processors (--at-once says otherwise), each in a
process of its own that is `test.py --suite NAME`; what a suite prints is shown when it has ended. Ends with a line for
each suite and one for all; the exit code is 0 only where nothing failed. Where the Python that a Blender needs is
neither here nor can be fetched, its suites are MISSING: said loudly, and a failure where the environment variable CI is
set. --slow adds what is marked slow (pytest) or ignored (cargo).
"""

import argparse
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
from build.console import Failure, PythonMissing, say
from build.layout import BUILD, ROOT, SCRIPTS
from build.once import building, fingerprint
from testing import side_by_side

PASSED, FAILED, MISSING = "passed", "FAILED", "MISSING"
EXIT_CODES = {PASSED: 0, FAILED: 1, MISSING: 3}  # of one suite; Python's own for wrong arguments is 2


@dataclass(frozen=True)
class Suite:
    """Something that holds or does not; `holds` may raise Failure instead of saying False."""

    group: str
    name: str
    holds: Callable[[], bool]


def suites(versions: list[str], slow: bool) -> list[Suite]:
    """All suites in the order in which to begin them.

    cargo's, of which one runs at a time, are a long chain; the first of the others builds the wheel beside it, and the
    longest follow, so that short ones are left to even out the end.
    """
    ignored = ["--", "--include-ignored"] if slow else []
    every = ["--workspace", "--locked"]
    rust = [
        Suite("rust", "cargo fmt", lambda: cargo("fmt", "--all", "--check")),
        Suite("rust", "cargo clippy", lambda: cargo("clippy", *every, "--all-targets", "--", "-D", "warnings")),
        Suite("rust", "cargo test", lambda: cargo("test", *every, *ignored)),
        Suite("rust", "cargo doc", lambda: cargo("doc", *every, "--no-deps", RUSTDOCFLAGS="-D warnings")),
    ]
    binding = [
        Suite(
            "binding", f"binding, Python {environment.PYTHON_OF_BLENDER[version]}", lambda v=version: test_binding(v, slow)
        )
        for version in versions
    ]
    scripts = [
        Suite("scripts", "scripts", lambda: test_scripts("tests/scripts", versions, slow)),
        Suite("scripts", "farms", lambda: test_scripts("tests/farm", versions, slow)),
    ]
    in_blender = [
        Suite("blender", f"extension, Blender {version}", lambda v=version: test_in_blender(v, slow)) for version in versions
    ]
    return [*rust, *binding[:1], *in_blender, *scripts, *binding[1:]]


def cargo(*arguments: str, **env: str) -> bool:
    if shutil.which("cargo") is None:
        raise Failure(build_wheel.RUST_MISSING)
    return succeeds(["cargo", *arguments], env)


def test_binding(version: str, slow: bool) -> bool:
    """tests/core with the Python of this Blender, whose numpy is the oldest or newest we promise, without bpy."""
    python = environment.blender(version)
    return succeeds([python, "-m", "pytest", *pytest_options("tests/core", slow)], {"PYTHONPATH": str(unpacked_wheel())})


def test_scripts(folder: str, versions: list[str], slow: bool) -> bool:
    """A folder of tests with the Python of the first Blender that can be had; they run scripts in all that are there."""
    pythons = []
    for version in versions:  # made here, because the tests skip those that are not there
        with suppress(PythonMissing):  # said by the suites of that Blender
            pythons.append(environment.blender(version))
    if not pythons:
        raise PythonMissing(f"no Python for Blender {' or '.join(versions)}")
    return succeeds([pythons[0], "-m", "pytest", *pytest_options(folder, slow)], {})


def test_in_blender(version: str, slow: bool) -> bool:
    os.chdir(ROOT)
    return blender.run(version, SCRIPTS / "testing/pytest_in_blender.py", pytest_options("tests/blender", slow)) == 0


def pytest_options(folder: str, slow: bool) -> list[str]:
    chosen = [] if slow else ["-m", "not slow"]
    marks = ["--strict-markers", "-o", "markers=slow: takes long, and runs only with test.py --slow"]
    return [folder, "-q", "-ra", "--durations=3", "--rootdir", str(ROOT), "-p", "no:cacheprovider", *marks, *chosen]


def unpacked_wheel() -> Path:
    """The folder that, on PYTHONPATH, is the wheel installed."""
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
    except PythonMissing as error:
        say(f"{'!' * 20} {suite.name} CANNOT BE TESTED HERE {'!' * 20}\n{error}")
        return MISSING
    except Failure as error:
        say(f"{suite.name}: {error}")
        return FAILED


def run_alone(suite: Suite) -> str:
    """Runs a suite in this process and says what it took."""
    say(f"----- {suite.name}")
    start = time.perf_counter()
    result = result_of(suite)
    spent = os.times()
    processors = spent.user + spent.system + spent.children_user + spent.children_system
    say(f"{suite.name}: {result} in {time.perf_counter() - start:.1f} s, {processors:.1f} s of processors")
    return result


def run_side_by_side(chosen: list[Suite], further: list[str], at_once: int) -> dict[str, tuple[str, float]]:
    """Runs suites in processes of their own; returns result and seconds of each by its name."""
    commands = [
        side_by_side.Command(
            suite.name, [sys.executable, SCRIPTS / "test.py", "--suite", suite.name, *further], ROOT,
            one_of="cargo" if suite.group == "rust" else None,  # another would wait for its lock
        )
        for suite in chosen
    ]  # fmt: skip
    found = {}
    for ended in side_by_side.run(commands, at_once):
        print(ended.output, flush=True)
        result = next((result for result, code in EXIT_CODES.items() if code == ended.code), FAILED)
        found[ended.command.name] = result, ended.seconds
        still = len(chosen) - len(found)
        say(f"{ended.command.name} {result} after {ended.seconds:.1f} s; {still or 'no'} more to come")
    return found


def main() -> int:
    parser = argparse.ArgumentParser(description="Builds and tests everything.")
    parser.add_argument("--only", choices=["rust", "binding", "scripts", "blender"])
    parser.add_argument("--blender", choices=environment.BLENDERS, help="this one only, and its Python")
    parser.add_argument("--slow", action="store_true", help="what takes long, too")
    parser.add_argument("--at-once", type=int, default=os.cpu_count() or 1, metavar="N", help="suites that run at a time")
    parser.add_argument(
        "--suite", metavar="NAME", help=f"this one alone; its exit code is {EXIT_CODES[MISSING]} where MISSING"
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
    further = [*(["--blender", wanted.blender] if wanted.blender else []), *(["--slow"] if wanted.slow else [])]
    found = run_side_by_side(chosen, further, max(wanted.at_once, 1))

    results = {result for result, _ in found.values()}
    lines = [f"{suite.name:<24} {found[suite.name][0]:<8} {found[suite.name][1]:6.1f} s" for suite in chosen]
    bad = {FAILED, MISSING} if os.environ.get("CI") else {FAILED}
    overall = FAILED if results & bad else f"{PASSED}, BUT NOT EVERYTHING WAS TESTED" if MISSING in results else PASSED
    print("\n" + "\n".join(lines), f"\n{'all':<24} {overall:<8} {time.perf_counter() - start:6.1f} s", sep="", flush=True)
    return 0 if overall != FAILED else 1


if __name__ == "__main__":
    try:
        sys.exit(main())
    except KeyboardInterrupt:
        sys.exit(130)
