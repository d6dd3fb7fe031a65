# SPDX-License-Identifier: GPL-3.0-or-later
"""The log: the last messages in memory, for reports, and all of them in a file if the user chose one."""

import logging
from collections import deque
from pathlib import Path

LEVELS = ("ERROR", "WARNING", "INFO", "DEBUG")
MOST_LINES = 200
_FORMAT = "%(asctime)s %(levelname)s %(message)s"

_logger = logging.getLogger("sinew")
_lines: deque[str] = deque(maxlen=MOST_LINES)
_file: logging.FileHandler | None = None


class _Memory(logging.Handler):
    def emit(self, record):
        _lines.append(self.format(record))


_memory = _Memory()
_memory.setFormatter(logging.Formatter(_FORMAT))
# what Python itself does for a logger without handlers
_console = logging.StreamHandler()
_console.setLevel(logging.WARNING)


def start():
    """Begins to keep messages. Errors and warnings still go to the system console."""
    for handler in (_memory, _console):
        if handler not in _logger.handlers:
            _logger.addHandler(handler)


def stop():
    """Ends keeping messages, and closes the file."""
    for handler in (_memory, _console):
        _logger.removeHandler(handler)
    write_to("")
    _lines.clear()


def set_level(level: str):
    """Keeps messages from this level on: one of `LEVELS`."""
    _logger.setLevel(level)


def write_to(path: str):
    """Also writes messages to the end of a file. An empty path: to no file. Raises OSError if it can't be written."""
    global _file
    if _file is not None:
        _logger.removeHandler(_file)
        _file.close()
        _file = None
    if path:
        opened = logging.FileHandler(Path(path), encoding="utf-8")
        opened.setFormatter(logging.Formatter(_FORMAT))
        _logger.addHandler(opened)
        _file = opened


def last_lines() -> list[str]:
    """The last messages, oldest first."""
    return list(_lines)
