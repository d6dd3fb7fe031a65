"""Builds a thing only once: a lock between processes, and fingerprints of the files that the thing is made from."""

import hashlib
import os
import sys
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path

from build.console import say
from build.layout import BUILD

if sys.platform == "win32":
    import msvcrt
    import time
else:
    import fcntl

_held = False


@contextmanager
def building() -> Iterator[None]:
    """Holds the lock of .build, in which one process at a time builds. A process that holds the lock may enter again.

    The operating system frees the lock when a process dies, so a lock is never left behind.
    """
    global _held
    if _held:
        yield
        return
    BUILD.mkdir(exist_ok=True)
    with open(BUILD / "lock", "a+b") as file:
        if not _try_lock(file):
            say("waiting for another build to finish ...")
            _wait_lock(file)
        _held = True
        try:
            yield
        finally:
            _held = False


if sys.platform == "win32":

    def _try_lock(file) -> bool:
        file.seek(0)
        try:
            msvcrt.locking(file.fileno(), msvcrt.LK_NBLCK, 1)
        except OSError:
            return False
        return True

    def _wait_lock(file) -> None:
        while not _try_lock(file):
            time.sleep(0.2)

else:

    def _try_lock(file) -> bool:
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            return False
        return True

    def _wait_lock(file) -> None:
        fcntl.flock(file, fcntl.LOCK_EX)


def files_under(folder: Path, leave_out: Iterable[str] = ()) -> list[Path]:
    """All files below a folder, sorted, without caches, hidden files and the folders named in `leave_out`."""
    skipped = {"__pycache__", *leave_out}
    files_found = []
    for top, folders, files in os.walk(folder):
        folders[:] = sorted(name for name in folders if name not in skipped and not name.startswith("."))
        files_found += [Path(top, name) for name in files if not name.startswith(".") and not name.endswith(".pyc")]
    return sorted(files_found)


def fingerprint(root: Path, files: Iterable[Path], *also: str) -> str:
    """A short hash of the files' names below `root`, of their contents, and of the texts in `also`."""
    digest = hashlib.sha256()
    for text in also:
        digest.update(text.encode() + b"\0")
    for file in files:
        digest.update(file.relative_to(root).as_posix().encode() + b"\0")
        digest.update(hashlib.sha256(file.read_bytes()).digest())
    return digest.hexdigest()[:16]


def is_stamped(stamp: Path, mark: str) -> bool:
    """Whether the stamp file holds this fingerprint, so that the thing beside it is up to date."""
    return stamp.is_file() and stamp.read_text() == mark
