# SPDX-License-Identifier: GPL-3.0-or-later
"""The output of a command: progress and messages on standard error, its result on standard output or in a file."""

import json
import sys
import time
from collections.abc import Iterable
from pathlib import Path

from ..errors import SinewError
from ..files.atomic_write import atomic_write

BETWEEN_PROGRESS_S = 1.0


class WrongArguments(SinewError):
    """Arguments that are wrong together, which their parser does not see."""


class Reporter:
    """Prints the messages and the result of one command.

    as_json: write the result to standard output as JSON. report: also write it to this file, or None.
    """

    def __init__(self, as_json: bool, report: str | None):
        self._as_json, self._report = as_json, Path(report) if report else None
        self._warnings: list[str] = []
        self._began_s = time.perf_counter()

    def say(self, message: str):
        """Prints a message."""
        print(f"sinew: {message}", file=sys.stderr, flush=True)

    def warn(self, message: str):
        """Prints a message and adds it to the result."""
        self._warnings.append(message)
        self.say(f"warning: {message}")

    def follow(self, steps: Iterable[float], label: str):
        """Runs work that yields the fraction done, 0..1, and prints it once per second. label: names the work."""
        printed_s = 0.0
        for done in steps:
            now_s = time.perf_counter()
            if done >= 1.0 or now_s - printed_s >= BETWEEN_PROGRESS_S:
                self.say(f"{label}: {done:.0%}")
                printed_s = now_s

    def result(self, fields: dict):
        """Writes the result of a command that succeeded. Its field `text`, if any, is printed where no JSON is requested."""
        text = fields.pop("text", None)
        if text and not self._as_json:
            print(text, flush=True)
        seconds = round(time.perf_counter() - self._began_s, 3)
        self._write({"ok": True, **fields, "warnings": self._warnings, "seconds": seconds})

    def failure(self, message: str, exit_code: int) -> int:
        """Writes an error and returns the exit code."""
        self.say(f"error: {message}")
        try:
            self._write({"ok": False, "error": message, "exit_code": exit_code, "warnings": self._warnings})
        except SinewError as error:
            self.say(f"error: {error}")
        return exit_code

    def _write(self, fields: dict):
        line = json.dumps(fields, ensure_ascii=True) + "\n"
        if self._report:
            with atomic_write(self._report) as file:
                file.write(line.encode())
        if self._as_json:
            print(line, end="", flush=True)
