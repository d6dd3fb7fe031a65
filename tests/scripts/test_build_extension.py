"""The extension's zip: its contents, and that the same sources give the same bytes."""

import tomllib
import zipfile

import pytest
from build import extension


def test_wheels_and_platforms_come_before_the_first_table():
    text = 'id = "sinew"\ntags = ["Rigging"]\n\n[permissions]\nfiles = "Saves presets"\n'
    read = tomllib.loads(extension.with_wheels(text, ["./wheels/a.whl"], ["linux-x64"]))
    assert read == {
        "id": "sinew",
        "tags": ["Rigging"],
        "wheels": ["./wheels/a.whl"],
        "platforms": ["linux-x64"],
        "permissions": {"files": "Saves presets"},
    }


@pytest.fixture(scope="module")
def archive(a_version):
    with zipfile.ZipFile(extension.build(a_version)) as opened:
        yield opened


def test_the_zip_holds_the_add_on_and_its_wheel_but_no_tests_or_caches(archive):
    names = archive.namelist()
    manifest = tomllib.loads(archive.read("blender_manifest.toml").decode())
    assert "__init__.py" in names
    assert [name for name in names if name.startswith("farm/")] == [
        "farm/dask/bake.py", "farm/dask/requirements.txt", "farm/flamenco/sinew_bake.js",
    ]  # fmt: skip
    assert [f"./{name}" for name in names if name.endswith(".whl")] == manifest["wheels"]
    assert not [name for name in names if "__pycache__" in name or "test" in name.lower() or name.endswith(".pyc")]


def test_the_manifest_follows_the_extension_platforms_rules(archive):
    manifest = tomllib.loads(archive.read("blender_manifest.toml").decode())
    assert manifest["id"] == "sinew"
    assert "blender" not in manifest["name"].lower()
    assert len(manifest["tagline"]) <= 64
    assert manifest["tagline"][-1].isalnum()
    assert manifest["license"] == ["SPDX:GPL-3.0-or-later"]


def test_the_same_sources_give_the_same_bytes(archive, tmp_path):
    wheel = next(name for name in archive.namelist() if name.endswith(".whl"))
    archive.extract(wheel, tmp_path)
    made = [tmp_path / "first.zip", tmp_path / "second.zip"]
    for target in made:
        extension.write(target, extension.files_under(extension.ADDON), [tmp_path / wheel], "")
    assert made[0].read_bytes() == made[1].read_bytes()
