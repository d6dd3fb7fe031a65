# SPDX-License-Identifier: GPL-3.0-or-later
"""Translates messages that are finished texts, by the templates of a language's table: "{} of {} vertices bound".

Messages are made where a thing is known, as f-strings. Here a message is compared with the templates of the table, and its
values are put into the template's translation, in the same order.
"""

import functools
import re

import bpy

from . import tables

_VALUE = "{}"
_MOST_NESTED = 4  # messages are made of sentences, and a sentence may quote another message


def translated(message: str) -> str:
    """The message in the language of Blender's user interface, or the message itself if it has no translation."""
    view = bpy.context.preferences.view
    language = bpy.app.translations.locale if view.use_translate_interface else ""
    return in_language(message, language) if language in tables.TABLES else message


@functools.lru_cache(maxsize=512)
def in_language(message: str, language: str, nested: int = 0) -> str:
    """The message in a language of `tables.TABLES`. nested: how deep the message is inside another one."""
    found = tables.TABLES[language].get(message)
    if found is not None:
        return found
    for pattern, template in _templates(language):
        match = pattern.fullmatch(message)
        if match:
            return template.format(*(_of_value(value, language, nested) for value in match.groups()))
    return message


def _of_value(value: str, language: str, nested: int) -> str:
    """A value in a language: only a sentence is translated, because a single word may be a name."""
    return in_language(value, language, nested + 1) if " " in value and nested < _MOST_NESTED else value


@functools.cache
def _templates(language: str) -> list[tuple[re.Pattern, str]]:
    """The templates of a table as patterns, with their translations. Those with more text of their own come first."""
    texts = [text for text in tables.TABLES[language] if _VALUE in text]
    texts.sort(key=lambda text: len(text.replace(_VALUE, "")), reverse=True)
    return [
        (re.compile("(.+?)".join(map(re.escape, text.split(_VALUE))), re.DOTALL), tables.TABLES[language][text])
        for text in texts
    ]
