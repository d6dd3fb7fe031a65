"""Builds and tests everything: the Rust core, its Python binding, the scripts, and the extension in every Blender.

usage: python3 scripts/test.py [--only rust|binding|scripts|blender] [--blender 5.2|4.5] [--slow]

Ends with a line for each suite and one for all; the exit code is 0 only where nothing failed. Where the Python that a
Blender needs is neither here nor can be fetched, its suites are MISSING: said loudly, and a failure where the
environment variable CI is set. --slow adds what is marked slow (pytest) or ignored (cargo).
"""

import argparse
import os
import shutil
import subprocess
import sys
import tempfile
import time
import zipfile
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

import blender
import build_wheel
import environment
from console import Failure, PythonMissing, say
from layout import BUILD, ROOT, SCRIPTS
from once import building, fingerprint

PASSED, FAILED, MISSING = "passed", "FAILED", "MISSING"


@dataclass(frozen=True)
class Suite:
    """Something that holds or does not; `holds` may raise Failure instead of saying False."""

    group: str
    name: str
    holds: Callable[[], bool]


def suites(versions: list[str], slow: bool) -> list[Suite]:
    """All suites in the order in which they fail most cheaply."""
    ignored = ["--", "--include-ignored"] if slow else []
    every = ["--workspace", "--locked"]
    rust = [
        Suite("rust", "cargo fmt", lambda: cargo("fmt", "--all", "--check")),
        Suite("rust", "cargo clippy", lambda: cargo("clippy", *every, "--all-targets", "--", "-D", "warnings")),
        Suite("rust", "cargo test", lambda: cargo("test", *every, *ignored)),
        Suite("rust", "cargo doc", lambda: cargo("doc", *every, "--no-deps", RUSTDOCFLAGS="-D warnings")),
    ]
    binding = [
        Suite("binding", f"binding, Python {environment.PYTHON_OF_BLENDER[version]}", lambda v=version: test_binding(v, slow))
        for version in versions
    ]
    scripts = [
        Suite("scripts", "scripts", lambda: test_scripts("tests/scripts", versions, slow)),
        Suite("scripts", "farms", lambda: test_scripts("tests/farm", versions, slow)),
    ]
    alongside = [Alongside(version, slow) for version in versions[1:]]

    def first_in_blender() -> bool:
        for other in alongside:
            with suppress(PythonMissing):  # its own suite says so
                other.start()
        return test_in_blender(versions[0], slow)

    in_blender = [
        Suite("blender", f"extension, Blender {versions[0]}", first_in_blender),
        *(Suite("blender", f"extension, Blender {other.version}", other.holds) for other in alongside),
    ]
    return [*rust, *binding, *scripts, *in_blender]


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
    for version in versions:
        try:
            python = environment.blender(version)
        except PythonMissing:
            continue  # said by the suites of that Blender
        return succeeds([python, "-m", "pytest", *pytest_options(folder, slow)], {})
    raise PythonMissing(f"no Python for Blender {' or '.join(versions)}")


def test_in_blender(version: str, slow: bool) -> bool:
    os.chdir(ROOT)
    return blender.run(version, SCRIPTS / "pytest_in_blender.py", pytest_options("tests/blender", slow)) == 0


class Alongside:
    """The suite of one Blender in a process of its own, while another's runs: either keeps one core busy.

    What it prints is shown when it is done, and the time in the last lines is what it took longer than the other.
    """

    def __init__(self, version: str, slow: bool):
        self.version, self._slow = version, slow
        self._process = None
        self._output = None

    def start(self) -> None:
        environment.blender(self.version)  # says here where there is no Python for it
        command = [sys.executable, SCRIPTS / "test.py", "--only", "blender", "--blender", self.version]
        self._output = tempfile.TemporaryFile("w+", encoding="utf-8", errors="replace")
        self._process = subprocess.Popen(
            [*command, "--slow"] if self._slow else command, cwd=ROOT, stdout=self._output, stderr=subprocess.STDOUT
        )

    def holds(self) -> bool:
        if self._process is None:
            self.start()
        code = self._process.wait()
        self._output.seek(0)
        print(self._output.read(), flush=True)
        return code == 0


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


def main() -> int:
    parser = argparse.ArgumentParser(description="Builds and tests everything.")
    parser.add_argument("--only", choices=["rust", "binding", "scripts", "blender"])
    parser.add_argument("--blender", choices=environment.BLENDERS, help="this one only, and its Python")
    parser.add_argument("--slow", action="store_true", help="what takes long, too")
    wanted = parser.parse_args()

    lines, results, start = [], set(), time.perf_counter()
    for suite in suites([wanted.blender] if wanted.blender else list(environment.BLENDERS), wanted.slow):
        if wanted.only not in (None, suite.group):
            continue
        say(f"----- {suite.name}")
        suite_start = time.perf_counter()
        result = result_of(suite)
        results.add(result)
        lines.append(f"{suite.name:<24} {result:<8} {time.perf_counter() - suite_start:6.1f} s")

    bad = {FAILED, MISSING} if os.environ.get("CI") else {FAILED}
    overall = FAILED if results & bad else f"{PASSED}, BUT NOT EVERYTHING WAS TESTED" if MISSING in results else PASSED
    print("\n" + "\n".join(lines), f"\n{'all':<24} {overall:<8} {time.perf_counter() - start:6.1f} s", sep="", flush=True)
    return 0 if overall != FAILED else 1


if __name__ == "__main__":
    sys.exit(main())
