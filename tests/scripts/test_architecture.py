"""The rooms: imports follow the order of the rooms, and never form a circle."""

import re

import pytest
from build.layout import ROOT
from testing import imports


@pytest.mark.parametrize(
    ("found", "rooms"),
    [(imports.of_addon(), imports.ADDON_ROOMS), (imports.of_core(), imports.CORE_ROOMS)],
    ids=["addon", "core"],
)
def test_rooms_import_from_earlier_rooms_only(found, rooms):
    assert len(found) > 100
    assert imports.against_order(found, rooms) == []


@pytest.mark.parametrize("found", [imports.of_addon(), imports.of_core()], ids=["addon", "core"])
def test_no_module_imports_itself_through_others(found):
    assert imports.circles(found) == []


def test_an_import_of_a_later_room_is_found():
    upward = imports.Import(imports.ADDON / "files/a.py", "files.a", "ui.panel")
    assert imports.against_order([upward], imports.ADDON_ROOMS) == ["files.a imports ui.panel"]
    back = imports.Import(imports.ADDON / "ui/panel.py", "ui.panel", "files.a")
    assert imports.circles([upward, back]) == [["files.a", "ui.panel"]]


def test_the_page_names_files_that_exist():
    page = (ROOT / "docs/ARCHITECTURE.md").read_text(encoding="utf-8")
    named = {name for name in re.findall(r"`([\w./]+)`", page) if "/" in name or name.endswith((".py", ".rs", ".md"))}
    assert len(named) > 30
    assert sorted(name for name in named if not (ROOT / name).exists() and not (ROOT / "scripts" / name).exists()) == []
