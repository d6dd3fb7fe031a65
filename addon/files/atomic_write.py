# SPDX-License-Identifier: GPL-3.0-or-later
"""Writes files atomically: into a temporary file in the same folder, flushed to disk, then renamed over the target.

Whenever the process ends, the target is either the complete old file or the complete new one (POSIX rename, Windows
MoveFileEx). The next write to the same target removes temporary files that a killed process left.
"""

import os
import platform
import re
import secrets
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import BinaryIO

from ..errors import SinewError

ABANDONED_AFTER_S = 24 * 3600.0  # for files of other machines, whose processes can't be looked up from here
LONGEST_MACHINE = 40
_UNFINISHED = ".sinew-part"
_FOREIGN = re.compile(r"[^A-Za-z0-9-]")


class NotWritten(SinewError):
    """A file could not be written. The old file, if there was one, is unchanged."""


@contextmanager
def atomic_write(path: Path) -> Iterator[BinaryIO]:
    """A new binary file that becomes `path` when the block ends, or is removed if the block raises an error.

    The folder must exist. Raises NotWritten if the system refuses, for example on a full disk.
    """
    with atomic_path(path) as unfinished, open(unfinished, "xb") as file:
        yield file


@contextmanager
def atomic_path(path: Path) -> Iterator[Path]:
    """Like `atomic_write`, for writers that need a path: the temporary path to write to, with the suffix of `path`."""
    path = Path(os.path.realpath(path))  # replaces the file that a symbolic link points to, not the link
    if os.path.isdir(path):
        raise NotWritten(f"{path} is a folder: choose another name")
    unfinished = path.with_name(f".{path.stem}.{_machine()}.{os.getpid()}.{secrets.token_hex(4)}{_UNFINISHED}{path.suffix}")
    try:
        _remove_abandoned(path)
        yield unfinished
        _flush(unfinished)
        os.replace(unfinished, path)
        _flush_folder(path.parent)
    except OSError as error:
        raise NotWritten(
            f"{path} could not be written ({error.strerror or error}); an existing file there is unchanged"
        ) from error
    finally:
        # if this fails, the write has failed too, and that error is reported
        with suppress(OSError):
            unfinished.unlink()


def make_folder(folder: Path):
    """Makes a folder and its parents. Raises NotWritten if that can't be done."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise NotWritten(f"The folder {folder} could not be made ({error.strerror or error}): choose another") from error


def _flush(written: Path):
    with open(written, "r+b") as file:
        os.fsync(file.fileno())


def _flush_folder(folder: Path):
    """Makes the rename durable. Windows has no flush for folders and needs none."""
    if os.name == "nt":
        return
    opened = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(opened)
    finally:
        os.close(opened)


def _remove_abandoned(path: Path):
    """Removes temporary files of this target whose processes have ended."""
    pattern = re.compile(
        re.escape(f".{path.stem}.") + r"([A-Za-z0-9-]+)\.(\d+)\.[0-9a-f]{8}" + re.escape(f"{_UNFINISHED}{path.suffix}")
    )
    for entry in path.parent.iterdir():
        match = pattern.fullmatch(entry.name)
        if match and _is_abandoned(entry, match[1], int(match[2])):
            try:
                entry.unlink(missing_ok=True)
            except OSError:
                continue  # open in Windows, or another user's: it only takes disk space


def _is_abandoned(entry: Path, machine: str, process: int) -> bool:
    if machine != _machine():
        try:
            return time.time() - entry.stat().st_mtime > ABANDONED_AFTER_S
        except FileNotFoundError:
            return False
    if process == os.getpid():
        return False  # another writer in this process
    if os.name == "nt":
        return True  # Windows refuses to remove a file that is open; os.kill would end the process there
    try:
        os.kill(process, 0)
    except ProcessLookupError:
        return True
    except PermissionError:
        return False  # a running process of another user
    return False


def _machine() -> str:
    return _FOREIGN.sub("-", platform.node())[:LONGEST_MACHINE] or "machine"
