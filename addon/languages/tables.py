# SPDX-License-Identifier: GPL-3.0-or-later
"""The tables of all languages. Blender translates labels and tooltips by them if the user chose the language.

A text that has no translation is shown in English. To add a language, write a folder as of German and add it to `TABLES`.
"""

import bpy

from . import chinese, german

TABLES = {"de_DE": german.TEXTS, "zh_HANS": chinese.TEXTS}
# Blender looks up labels of operators in a context of their own
CONTEXTS = ("*", "Operator")
_OWNER = __package__


def register():
    bpy.app.translations.register(
        _OWNER,
        {
            language: {(context, text): translated for text, translated in texts.items() for context in CONTEXTS}
            for language, texts in TABLES.items()
        },
    )


def unregister():
    bpy.app.translations.unregister(_OWNER)
