# SPDX-License-Identifier: GPL-3.0-or-later
"""Unexpected exceptions in one character, which must not stop the others: each is logged once, until the character works."""

import logging
from collections.abc import Hashable, Iterator
from contextlib import contextmanager

_logger = logging.getLogger("sinew")
_failures: dict[Hashable, str] = {}


def has_any() -> bool:
    """Whether anything failed the last time."""
    return bool(_failures)


def forget():
    """The next failures are logged again, whatever failed before."""
    _failures.clear()


def log(key: Hashable, what: str, error: Exception) -> str:
    """Logs an exception with its traceback, unless it is the last one of `key`. Returns the reason for the panel.

    what: what failed, as the start of a sentence.
    """
    reason = f"{what}: unexpected {type(error).__name__}: {error}. The system console shows where"
    if _failures.get(key) != reason:
        _failures[key] = reason
        _logger.error("%s", reason, exc_info=error)
    return reason


def clear(key: Hashable):
    """What `key` names works again: its next failure is logged."""
    _failures.pop(key, None)


@contextmanager
def isolated(key: Hashable, what: str) -> Iterator[None]:
    """Logs an exception of the block instead of raising it. Parameters: as for `log`."""
    try:
        yield
    except Exception as error:
        log(key, what, error)
    else:
        clear(key)
