# SPDX-License-Identifier: GPL-3.0-or-later
"""The user interface in other languages: each table has every label that a person reads."""

import bpy
import pytest
from bl_ext.user_default.sinew import operators, ui
from bl_ext.user_default.sinew.languages import tables as languages
from bl_ext.user_default.sinew.settings import group_settings, rig_settings, tissue_settings

# letters and names that are the same in every language
SAME = {"X", "Y", "Z", "-X", "-Y", "-Z", "Sinew", "Name"}
# written by Sinew, not read by a person
HIDDEN = {"Disabled by Layer", "Chosen Tissue", "Hidden Meshes", "Mesh", "Shaded Object", "Export Copy"}


def labels():
    found = {cls.bl_label for cls in operators.CLASSES if issubclass(cls, bpy.types.Operator)}
    found |= {cls.bl_label for cls in ui._CLASSES if getattr(cls, "bl_label", "")}
    for cls in (*rig_settings.CLASSES, *tissue_settings.CLASSES, *group_settings.CLASSES):
        for prop in cls.bl_rna.properties:
            if prop.identifier != "rna_type" and not prop.is_hidden:
                found.add(prop.name)
                found |= {item.name for item in prop.enum_items_static} if prop.type == "ENUM" else set()
    return found - SAME - HIDDEN


@pytest.mark.parametrize("language", languages.TABLES)
def test_a_table_has_every_label(language):
    assert len(labels()) > 90
    assert sorted(labels() - languages.TABLES[language].keys()) == []


@pytest.mark.parametrize("language", languages.TABLES)
def test_placeholders_are_kept(language):
    for text, translated in languages.TABLES[language].items():
        assert translated.strip() and text.count("{}") == translated.count("{}"), text


def test_tables_have_the_same_texts():
    german, chinese = languages.TABLES.values()
    assert german.keys() == chinese.keys()


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
