# SPDX-License-Identifier: GPL-3.0-or-later
"""*Online Manual* leads from every operator and setting to a heading that exists in the documentation."""

import bpy
import pytest
from bl_ext.user_default.sinew.ui import online_manual
from build.layout import ROOT
from docs_site import pages

PATTERNS = dict(online_manual.pages())


def test_every_page_and_heading_exists():
    assert len(PATTERNS) > 30
    for target in PATTERNS.values():
        page, _, anchor = target.partition("#")
        assert anchor in pages.anchors_of(ROOT / "docs" / page.replace(".html", ".md")), target


def test_every_operator_and_every_group_of_settings_has_a_page():
    groups = [
        bpy.types.Object.bl_rna.properties["sinew"].fixed_type,
        bpy.types.PoseBone.bl_rna.properties["sinew"].fixed_type,
    ]
    groups += [
        known.fixed_type for known in groups[0].properties if known.type == "POINTER" and known.identifier != "rna_type"
    ]
    names = {group.identifier for group in groups} - {"SinewObjectSettings"}
    assert {f"bpy.types.{name.lower()}.*" for name in names} <= set(PATTERNS)
    assert {f"bpy.ops.sinew.{name}*" for name in dir(bpy.ops.sinew)} <= set(PATTERNS)


def found_by_blender(name):
    """The page that Blender's context menu opens for a name: the first map, and in it the first pattern that matches."""
    return bpy.types.WM_OT_doc_view_manual._lookup_rna_url(name, verbose=False)


def test_blender_finds_the_page_where_the_manifest_has_a_website(monkeypatch):
    monkeypatch.setattr(online_manual, "website", lambda: "https://sinew.example/")
    online_manual.register()
    try:
        assert found_by_blender("bpy.ops.sinew.bind") == "https://sinew.example/operators.html#sinewbind"
        assert found_by_blender("bpy.ops.sinew.bake_bones") == "https://sinew.example/operators.html#sinewbake_bones"
        assert found_by_blender("bpy.types.SinewSkinSettings.falloff").startswith(
            "https://sinew.example/settings.html#skins"
        )
    finally:
        online_manual.unregister()
    assert not (found_by_blender("bpy.ops.sinew.bind") or "").startswith("https://sinew.example/")


@pytest.mark.parametrize(
    ("line", "address"),
    [
        ("", ""),
        ('website = "https://sinew.example"', "https://sinew.example/"),
        ('website = "https://a.b/"', "https://a.b/"),
    ],
)
def test_the_address_is_that_of_the_manifest(monkeypatch, tmp_path, line, address):
    manifest = tmp_path / "blender_manifest.toml"
    manifest.write_text(f'id = "sinew"\n{line}\n', encoding="utf-8")
    monkeypatch.setattr(online_manual, "_MANIFEST", manifest)
    assert online_manual.website() == address
