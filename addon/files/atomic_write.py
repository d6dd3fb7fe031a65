# SPDX-License-Identifier: GPL-3.0-or-later
"""Files that are there whole or not at all: written beside their place, flushed to the disk, then renamed over it.

Whatever ends the process, and whenever, the old file stays as it was until the new one has its name (POSIX rename,
Windows MoveFileEx). What a killed process left unfinished is taken away by the next that writes the same file.
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

ABANDONED_AFTER_S = 24 * 3600.0  # for unfinished files of other machines, of which nobody here knows whether they live
LONGEST_MACHINE = 40
_UNFINISHED = ".sinew-part"
_FOREIGN = re.compile(r"[^A-Za-z0-9-]")


class NotWritten(SinewError):
    """A file could not be written; what stood in its place still does."""


@contextmanager
def atomic_write(path: Path) -> Iterator[BinaryIO]:
    """A new file to write to, which takes the name `path` when the block ends, and vanishes where it ends by an error.

    Raises NotWritten where the system refuses, such as on a full disk; the folder must be there.
    """
    with whole_path(path) as unfinished, open(unfinished, "xb") as file:
        yield file


@contextmanager
def whole_path(path: Path) -> Iterator[Path]:
    """As `atomic_write`, for writers that want a name: the place to write to, of the same suffix as `path`."""
    path = Path(os.path.realpath(path))  # a link stays one
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
            f"{path} could not be written ({error.strerror or error}); what was there before still is"
        ) from error
    finally:
        # where this fails, too, writing has failed before and was told
        with suppress(OSError):
            unfinished.unlink()


def make_folder(folder: Path):
    """Makes a folder, with those above it. Raises NotWritten where that can't be done."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise NotWritten(f"The folder {folder} could not be made ({error.strerror or error}): choose another") from error


def _flush(written: Path):
    with open(written, "r+b") as file:
        os.fsync(file.fileno())


def _flush_folder(folder: Path):
    """Makes the new name last, too; Windows has no such thing for folders and needs none."""
    if os.name == "nt":
        return
    opened = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(opened)
    finally:
        os.close(opened)


def _remove_abandoned(path: Path):
    """Removes what processes that are no more left of this file."""
    pattern = re.compile(
        re.escape(f".{path.stem}.") + r"([A-Za-z0-9-]+)\.(\d+)\.[0-9a-f]{8}" + re.escape(f"{_UNFINISHED}{path.suffix}")
    )
    for entry in path.parent.iterdir():
        match = pattern.fullmatch(entry.name)
        if match and _is_abandoned(entry, match[1], int(match[2])):
            try:
                entry.unlink(missing_ok=True)
            except OSError:
                continue  # still open in Windows, or another's: it costs room, and is no part of what is written here


def _is_abandoned(entry: Path, machine: str, process: int) -> bool:
    if machine != _machine():
        try:
            return time.time() - entry.stat().st_mtime > ABANDONED_AFTER_S
        except FileNotFoundError:
            return False
    if process == os.getpid():
        return False  # two writers of one process
    if os.name == "nt":
        return True  # where it is not, Windows does not let it be removed; asking os.kill there would end it
    try:
        os.kill(process, 0)
    except ProcessLookupError:
        return True
    except PermissionError:
        return False  # alive, and another user's
    return False


def _machine() -> str:
    return _FOREIGN.sub("-", platform.node())[:LONGEST_MACHINE] or "machine"
