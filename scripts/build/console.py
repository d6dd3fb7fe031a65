"""What a person sees while the scripts work: steps with their seconds, on stderr, and one kind of failure.

Standard output belongs to the scripts that run inside Blender.
"""

import subprocess
import sys
import time
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path


class Failure(Exception):
    """Something a person has to see to; the message says what to do."""


class PythonMissing(Failure):
    """No Python that fits the bpy asked for is here, and none could be fetched."""


def say(message: str) -> None:
    print(f"sinew: {message}", file=sys.stderr, flush=True)


@contextmanager
def step(what: str) -> Iterator[None]:
    """Announces a step when it starts and says how long it took when it is done."""
    say(f"{what} ...")
    start = time.perf_counter()
    yield
    say(f"{what}: {time.perf_counter() - start:.1f} s")


def run(command: Sequence[str | Path], *, cwd: Path | None = None, env: Mapping[str, str] | None = None) -> None:
    """Runs a quiet command; what it printed is shown only where it failed."""
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
