"""Runs commands side by side, and shows the output of each when it ends."""

import os
import signal
import subprocess
import tempfile
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import IO

from build.console import say
from build.layout import ON_WINDOWS

LOOK_EVERY_S = 0.05
GRACE_S = 20.0


@dataclass(frozen=True)
class Command:
    """A command that runs in `folder`. Commands with the same `one_of` run one at a time."""

    name: str
    words: Sequence[str | Path]
    folder: Path
    one_of: str | None = None


@dataclass(frozen=True)
class Ended:
    """The exit code of a command, its output on both streams, and its time."""

    command: Command
    code: int
    output: str
    seconds: float


class _Running:
    def __init__(self, command: Command):
        self.command, self._start = command, time.perf_counter()
        self._output: IO[str] = tempfile.TemporaryFile(  # noqa: SIM115 - _printed closes it
            "w+", encoding="utf-8", errors="replace"
        )
        self._process = subprocess.Popen(
            list(map(str, command.words)),
            cwd=command.folder,
            stdin=subprocess.DEVNULL,
            stdout=self._output,
            stderr=subprocess.STDOUT,
            process_group=None if ON_WINDOWS else 0,  # a group of its own, so that all its processes can be ended together
        )

    def ended(self) -> Ended | None:
        code = self._process.poll()
        if code is None:
            return None
        return Ended(self.command, code, self._printed(), time.perf_counter() - self._start)

    def ask_to_end(self) -> None:
        if ON_WINDOWS:
            self._process.terminate()
        else:
            self._signal(signal.SIGTERM)

    def make_end(self) -> str:
        """Waits for the end, kills the process after a while, and returns the output."""
        with suppress(subprocess.TimeoutExpired):
            self._process.wait(GRACE_S)
        if ON_WINDOWS:
            self._process.kill()
        else:
            self._signal(signal.SIGKILL)
        self._process.wait()
        return self._printed()

    def _printed(self) -> str:
        with self._output:
            self._output.seek(0)
            return self._output.read()

    def _signal(self, number: int) -> None:
        with suppress(ProcessLookupError):
            os.killpg(self._process.pid, number)


def run(commands: Sequence[Command], at_once: int) -> Iterator[Ended]:
    """Runs all commands, at most `at_once` at a time, and yields each when it has ended.

    Commands start in their order, as far as `one_of` allows. If the iteration ends early (Ctrl-C, SIGTERM, an exception in
    the caller), the running commands and all their processes are ended, and their output is shown.
    """
    waiting, running = list(commands), []
    with _termination_as_interrupt():
        try:
            while waiting or running:
                while len(running) < at_once and (following := _next(waiting, running)):
                    waiting.remove(following)
                    running.append(_Running(following))
                    say(f"{following.name} begins ...")
                for one in tuple(running):
                    if ended := one.ended():
                        running.remove(one)
                        yield ended
                time.sleep(LOOK_EVERY_S)
        finally:
            for one in running:
                one.ask_to_end()
            for one in running:
                print(f"{one.command.name} was ended. Its output:\n{one.make_end()}", flush=True)


def _next(waiting: Sequence[Command], running: Sequence[_Running]) -> Command | None:
    taken = {one.command.one_of for one in running} - {None}
    return next((command for command in waiting if command.one_of not in taken), None)


@contextmanager
def _termination_as_interrupt() -> Iterator[None]:
    def interrupt(*_):
        raise KeyboardInterrupt

    previous = signal.signal(signal.SIGTERM, interrupt)
    try:
        yield
    finally:
        signal.signal(signal.SIGTERM, previous)
