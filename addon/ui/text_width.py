# SPDX-License-Identifier: GPL-3.0-or-later
"""Texts that fit the sidebar: wrapped to several lines, or with shortened words. Widths are in pixels of the screen.

Blender cuts off a label that is too wide, and with it the words that tell similar names apart.
"""

import functools

import bpy
import blf

DEFAULT_SIDEBAR = 280.0  # at a resolution scale of 1, as are the widths below
# beside a panel's contents: its margins and the tabs of the sidebar
_MARGINS = 54.0
_ICON = 30.0
FEWEST_LETTERS = 2  # of a shortened word


def scale() -> float:
    """Pixels of the screen per unit of Blender's user interface."""
    return bpy.context.preferences.system.ui_scale or 1.0  # 0 without a window


def width_of(text: str) -> float:
    """The width of a label's text."""
    return _width(text, _letter_size())


def _letter_size() -> float:
    preferences = bpy.context.preferences
    return preferences.ui_styles[0].widget.points * (preferences.system.ui_scale or 1.0)


@functools.lru_cache(maxsize=4096)  # a panel draws the same texts again and again
def _width(text: str, size: float) -> float:
    blf.size(0, size)
    return blf.dimensions(0, text)[0]


def contents_width() -> float:
    """The width of a panel's contents in the sidebar that is being drawn, or in one of the default width."""
    region = bpy.context.region
    sidebar = region.width if region is not None and region.type == "UI" else DEFAULT_SIDEBAR * scale()
    return sidebar - _MARGINS * scale()


def wrapped(text: str) -> list[str]:
    """The lines of a text beside an icon."""
    room = contents_width() - _ICON * scale()
    lines, line = [], ""
    for word in _words(text):
        if line and width_of(line + word.rstrip()) > room:
            lines.append(line.rstrip())
            line = ""
        line += word
    return [*lines, line.rstrip()]


def shortened(name: str, room: float) -> str:
    """A name whose longest words are shortened, as in "Abd. dig. min. hand", until it is no wider than `room`."""
    return _shortened(name, room, _letter_size())


@functools.lru_cache(maxsize=4096)
def _shortened(name: str, room: float, size: float) -> str:
    if _width(name, size) <= room:
        return name
    words = [word for word in name.replace(",", "").split() if word not in ("of", "the")]
    lengths = [len(word) for word in words]
    while True:
        parts = [word if length == len(word) else f"{word[:length]}." for word, length in zip(words, lengths)]
        longest = max(0 if _is_number(word) else length for word, length in zip(words, lengths))
        if _width(" ".join(parts), size) <= room or longest <= FEWEST_LETTERS:
            return " ".join(parts)
        lengths[next(i for i, word in enumerate(words) if lengths[i] == longest and not _is_number(word))] -= 1


def _is_number(word: str) -> bool:
    """Whether a word has a digit, which tells names apart: it is not shortened."""
    return any(sign.isdigit() for sign in word)


def _words(text: str) -> list[str]:
    """The parts between which a line can end. Chinese and Japanese have no spaces: a line can end after each sign."""
    parts, word = [], ""
    for sign in text:
        word += sign
        if sign == " " or ord(sign) >= 0x2E80:
            parts.append(word)
            word = ""
    return [*parts, word] if word else parts
