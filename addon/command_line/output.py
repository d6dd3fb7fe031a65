# SPDX-License-Identifier: GPL-3.0-or-later
"""What a command tells: progress and messages on standard error, its result for programs on standard output or in a file."""

import json
import sys
import time
from collections.abc import Iterable
from pathlib import Path

from ..errors import SinewError
from ..files.atomic_write import atomic_write

BETWEEN_PROGRESS_S = 1.0


class Reporter:
    """Tells of one command. `as_json`: whether the result goes to standard output; `report`: the file it goes to, or None."""

    def __init__(self, as_json: bool, report: str | None):
        self._as_json, self._report = as_json, Path(report) if report else None
        self._warnings: list[str] = []
        self._began_s = time.perf_counter()

    def say(self, message: str):
        """A message for the person who reads along."""
        print(f"sinew: {message}", file=sys.stderr, flush=True)

    def warn(self, message: str):
        """A message that also stands in the result."""
        self._warnings.append(message)
        self.say(f"warning: {message}")

    def follow(self, steps: Iterable[float], what: str):
        """Runs work that yields the part done, 0..1, and tells how far it is, once a second."""
        told_s = 0.0
        for done in steps:
            now_s = time.perf_counter()
            if done >= 1.0 or now_s - told_s >= BETWEEN_PROGRESS_S:
                self.say(f"{what}: {done:.0%}")
                told_s = now_s

    def result(self, told: dict):
        """Tells that all went well; `text` of the result, if any, is for people and printed where no JSON is wanted."""
        text = told.pop("text", None)
        if text and not self._as_json:
            print(text, flush=True)
        seconds = round(time.perf_counter() - self._began_s, 3)
        self._tell({"ok": True, **told, "warnings": self._warnings, "seconds": seconds})

    def failure(self, message: str, exit_code: int) -> int:
        """Tells what went wrong; returns the exit code."""
        self.say(f"error: {message}")
        try:
            self._tell({"ok": False, "error": message, "exit_code": exit_code, "warnings": self._warnings})
        except SinewError as error:
            self.say(f"error: {error}")
        return exit_code

    def _tell(self, told: dict):
        line = json.dumps(told, ensure_ascii=True) + "\n"
        if self._report:
            with atomic_write(self._report) as file:
                file.write(line.encode())
        if self._as_json:
            print(line, end="", flush=True)
