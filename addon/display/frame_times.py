# SPDX-License-Identifier: GPL-3.0-or-later
"""Measures how long the parts of a frame take. While it is off, each call costs one comparison.

`live.frame` calls `begin`, then `lap` after each part, then `end`. A forecast before the evaluation calls `suspend` instead.
"""

import time
from collections import defaultdict

# weight of a new value in the running mean
_WEIGHT_OF_NEW = 0.2
# after a longer pause, a frame is not part of the same playback
_PAUSE_S = 1.0

_is_on = _is_suspended = False
_at = _began = 0.0
_ended = None
_current: dict[str, float] = defaultdict(float)
_mean_ms: dict[str, float] = {}
_mean_between_s = 0.0
_evaluations = ""


def switch(on: bool):
    """Starts or stops measuring, and forgets all measured times."""
    global _is_on, _is_suspended, _ended, _mean_between_s, _evaluations
    _is_on, _is_suspended, _ended, _mean_between_s, _evaluations = on, False, None, 0.0, ""
    _mean_ms.clear()
    _current.clear()


def is_on() -> bool:
    return _is_on


def begin():
    """Starts a frame, or its second half after `suspend`."""
    global _at, _began, _is_suspended
    if _is_on:
        if not _is_suspended:
            _current.clear()
        _is_suspended = False
        _at = _began = time.perf_counter()


def lap(part: str):
    """Counts the time since the last call as this part of the frame."""
    global _at
    if _is_on:
        now = time.perf_counter()
        _current[part] += now - _at
        _at = now


def suspend():
    """Stops measuring until the next call of `begin`, which continues the frame."""
    global _is_suspended
    if _is_on:
        _current["total"] += time.perf_counter() - _began
        _is_suspended = True


def end():
    """Ends the frame, and adds its times to the means."""
    global _ended, _mean_between_s
    if not _is_on:
        return
    now = time.perf_counter()
    _current["total"] += now - _began
    for part, seconds in _current.items():
        _mean_ms[part] = _mean(_mean_ms.get(part), 1000.0 * seconds)
    if _ended is not None and now - _ended < _PAUSE_S:
        _mean_between_s = _mean(_mean_between_s or None, now - _ended)
    _ended = now


def set_evaluations(line: str):
    """Sets the line that says how often Blender evaluates the meshes."""
    global _evaluations
    _evaluations = line


def evaluations() -> str:
    """The line that says how often Blender evaluates the meshes. Empty before the first frame."""
    return _evaluations


def means_ms() -> dict[str, float]:
    """Running means of the milliseconds of each part and of "total". Empty before the first frame."""
    return dict(_mean_ms)


def frames_per_second() -> float:
    """Running mean over frames that followed each other without a pause. 0 before there were any."""
    return 1.0 / _mean_between_s if _mean_between_s else 0.0


def _mean(before: float | None, now: float) -> float:
    return now if before is None else before + _WEIGHT_OF_NEW * (now - before)
