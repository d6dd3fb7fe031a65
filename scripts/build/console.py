"""Prints the progress of the scripts on stderr, and defines their errors.

Standard output is reserved for the scripts that run inside Blender.
"""

import subprocess
import sys
import time
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path


class Failure(Exception):
    """An error that the user has to solve; the message says how."""


class Missing(Failure):
    """A program that is needed is not installed on this machine."""


class PythonMissing(Missing):
    """The Python version that a bpy needs is not installed and could not be fetched."""


def say(message: str) -> None:
    print(f"sinew: {message}", file=sys.stderr, flush=True)


@contextmanager
def step(what: str) -> Iterator[None]:
    """Prints a step when it starts, and its seconds when it is done."""
    say(f"{what} ...")
    start = time.perf_counter()
    yield
    say(f"{what}: {time.perf_counter() - start:.1f} s")


def run(command: Sequence[str | Path], *, cwd: Path | None = None, env: Mapping[str, str] | None = None) -> None:
    """Runs a command without showing its output; if it fails, the output is in the error."""
    try:
        done = subprocess.run(
            list(map(str, command)),
            cwd=cwd,
            env=env,
            text=True,
            errors="replace",
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
        )
    except FileNotFoundError as error:
        raise Failure(f"{command[0]} was not found ({error})") from error
    if done.returncode != 0:
        raise Failure(f"{' '.join(map(str, command))}\nfailed with {done.returncode}:\n{done.stdout.rstrip()}")
