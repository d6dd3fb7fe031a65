# SPDX-License-Identifier: GPL-3.0-or-later
"""The user interface in other languages: tables have every label that a person reads, and nearly all other texts."""

import ast
from pathlib import Path

import bpy
import pytest
from bl_ext.user_default import sinew
from bl_ext.user_default.sinew import operators, ui
from bl_ext.user_default.sinew.languages import messages, tables
from bl_ext.user_default.sinew.settings import (
    bone_settings,
    goal_settings,
    group_settings,
    growth_settings,
    preferences,
    rig_settings,
    skin_settings,
    tissue_settings,
)

# letters and names that are the same in every language
SAME = {"X", "Y", "Z", "-X", "-Y", "-Z", "Sinew", "Name"}
# written by Sinew, not read by a person
HIDDEN = {"Disabled by Layer", "Chosen Tissue", "Hidden Meshes", "Mesh", "Shaded Object", "Export Copy", "bl_idname"}
# properties of Blender's base classes
OF_BLENDER = {
    "Filepath used for exporting the file",
    "Unique name used in the code and scripting, can be re-defined in Python sub-classes if needed",
}
LEAST_TOOLTIPS, LEAST_MESSAGES = 0.97, 0.9  # the others are shown in English
OPERATORS = [cls for cls in operators.CLASSES if issubclass(cls, bpy.types.Operator)]
SETTINGS = [
    cls
    for owner in (
        bone_settings,
        goal_settings,
        group_settings,
        growth_settings,
        preferences,
        rig_settings,
        skin_settings,
        tissue_settings,
    )
    for cls in vars(owner).values()
    if isinstance(cls, type) and issubclass(cls, (bpy.types.PropertyGroup, bpy.types.AddonPreferences)) and cls.is_registered
]


def properties():
    owners = [getattr(bpy.ops.sinew, cls.bl_idname.removeprefix("sinew.")).get_rna_type() for cls in OPERATORS]
    for owner in (*owners, *(cls.bl_rna for cls in SETTINGS)):
        yield from (found for found in owner.properties if found.identifier != "rna_type" and not found.is_hidden)


def labels():
    found = {cls.bl_label for cls in OPERATORS}
    found |= {cls.bl_label for cls in ui._CLASSES if getattr(cls, "bl_label", "")}
    for cls in SETTINGS:
        for prop in cls.bl_rna.properties:
            if prop.identifier != "rna_type" and not prop.is_hidden:
                found.add(prop.name)
                found |= {item.name for item in prop.enum_items_static} if prop.type == "ENUM" else set()
    return found - SAME - HIDDEN


def tooltips():
    found = {cls.__doc__ for cls in OPERATORS}
    for prop in properties():
        found.add(prop.description)
        found |= {item.description for item in prop.enum_items_static} if prop.type == "ENUM" else set()
    return {text for text in found if text and " " in text and text not in OF_BLENDER}


def template(node):
    """The text of an expression, with {} for its values, or an empty text."""
    if isinstance(node, ast.Constant) and isinstance(node.value, str):
        return node.value
    if isinstance(node, ast.JoinedStr):
        return "".join(part.value if isinstance(part, ast.Constant) else "{}" for part in node.values)
    return ""


def reports():
    """The messages of errors and reports, as templates, read from the sources."""
    found = set()
    for path in Path(sinew.__file__).parent.rglob("*.py"):
        if "languages" in path.parts or "command_line" in path.parts:
            continue
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Call):
                name = getattr(node.func, "attr", getattr(node.func, "id", ""))
                first = {"SinewError": 0, "report": 1, "poll_message_set": 0, "label_wrapped": 1}.get(name)
                if first is not None and len(node.args) > first:
                    found.add(template(node.args[first]))
    return {text for text in found if " " in text and any(sign.isalpha() for sign in text.replace("{}", ""))}


@pytest.mark.parametrize("language", tables.TABLES)
def test_a_table_has_every_label(language):
    assert len(labels()) > 90
    assert sorted(labels() - tables.TABLES[language].keys()) == []


@pytest.mark.parametrize("language", tables.TABLES)
@pytest.mark.parametrize(("texts", "fewest", "share"), [(tooltips, 250, LEAST_TOOLTIPS), (reports, 200, LEAST_MESSAGES)])
def test_a_table_has_most_texts(language, texts, fewest, share):
    known = texts()
    missing = sorted(known - tables.TABLES[language].keys())
    print("\n".join(missing))
    assert len(known) > fewest and len(missing) < (1.0 - share) * len(known)


@pytest.mark.parametrize("language", tables.TABLES)
def test_placeholders_are_kept(language):
    for text, translated in tables.TABLES[language].items():
        assert translated.strip() and text.count("{}") == translated.count("{}"), text


def test_tables_have_the_same_texts():
    german, chinese = tables.TABLES.values()
    assert german.keys() == chinese.keys()


@pytest.mark.parametrize(
    ("message", "wanted"),
    [
        ("12 of 480 vertices bound to 3 tissues", "12 von 480 Punkten an 3 Gewebe gebunden"),
        ("Body.001 is not bound. Bind it first (Bind Skin)", "Body.001 ist nicht gebunden. Zuerst binden (Haut binden)"),
        ("Muscles", "Muskeln"),
        ("Arm: Live is off", "Arm: Live ist aus"),
        ("a text of somebody else", "a text of somebody else"),
    ],
)
def test_a_message_is_translated_with_its_values(message, wanted):
    assert messages.in_language(message, "de_DE") == wanted


def test_a_value_that_is_a_word_stays():
    assert messages.in_language("Muscles is not bound", "de_DE") == "Muscles ist nicht gebunden"


@pytest.mark.parametrize(("language", "wanted"), [("de_DE", "Haut binden"), ("zh_HANS", "绑定皮肤")])
def test_blender_shows_the_language(language, wanted):
    view = bpy.context.preferences.view
    before = view.language
    try:
        view.language = language
    except TypeError:
        pytest.skip(f"this bpy has no language {language}")
    view.use_translate_interface = True
    try:
        assert bpy.app.translations.pgettext_iface("Bind Skin", "Operator") == wanted
    finally:
        view.language = before
