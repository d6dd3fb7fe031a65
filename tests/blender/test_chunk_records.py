# SPDX-License-Identifier: GPL-3.0-or-later
"""Records of chunks may come from strangers: `merge` refuses a faulty one in words, and opens and writes nothing."""

import json
import time

import bpy
import pytest
from bl_ext.user_default.sinew.bake.cache import chunk_records
from bl_ext.user_default.sinew.errors import SinewError
from test_command_line import bake, command, saved  # noqa: F401 - fixtures

pytestmark = pytest.mark.one_blender

MISSING = object()


@pytest.fixture
def parts(command, saved, tmp_path):  # noqa: F811
    """A folder with the two chunks of a bake."""
    for number in (1, 2):
        assert bake(command, saved, tmp_path / "parts", "--chunk", f"{number}/2")[0] == 0
    return tmp_path / "parts"


def change(path, fields, keep_fingerprint=False):
    """Changes fields of a record, "job.x" for those of its job, and forges the fingerprint to match."""
    from bl_ext.user_default.sinew.bake.cache.chunks import Job

    record = json.loads(path.read_text())
    for field, value in fields.items():
        owner = record["job"] if field.startswith("job.") else record
        name = field.removeprefix("job.")
        if value is MISSING:
            del owner[name]
        else:
            owner[name] = value
    is_job = isinstance(record.get("job"), dict) and record["job"].keys() == Job.__dataclass_fields__.keys()
    if not keep_fingerprint and "fingerprint" not in fields and is_job:
        record["fingerprint"] = Job(**record["job"]).fingerprint
    path.write_text(json.dumps(record))


@pytest.mark.parametrize(
    ("field", "value"),
    [
        ("fingerprint", MISSING),
        ("fingerprint", "x"),
        ("sinew_chunk", "1"),
        ("job", MISSING),
        ("job", []),
        ("number", [1]),
        ("number", 0),
        ("number", 3),
        ("number", True),
        ("sha256", "../x"),
        ("blend", 3),
        ("surprise", 1),
        ("job.of", 0),
        ("job.of", -3),
        ("job.of", "3"),
        ("job.of", 3.0),
        ("job.of", 1_000_000_000),
        ("job.step", 0),
        ("job.last", 10**12),
        ("job.last", 10**400),
        ("job.first", 1e300),
        ("job.vertices", -1),
        ("job.vertices", 3.5),
        ("job.vertices", 10**12),
        ("job.vertices", None),
        ("job.file_format", "EXE"),
        ("job.points", "NONE"),
        ("job.up_axis", "Q"),
        ("job.scene", {}),
        ("job.object", ""),
        ("job.object", "x" * 300),
        ("job.frames_per_second", 0),
        ("job.frames_per_second", float("nan")),
        ("job.surprise", 1),
    ],
)
def test_a_wrong_field_is_refused_with_its_line(command, parts, field, value):  # noqa: F811
    change(parts / "Arm.1-of-2.pc2.json", {field: value})
    before = sorted(parts.iterdir())
    code, _out, err = command("merge", parts)
    assert code == 3 and "Arm.1-of-2.pc2.json, line 1: '" in err and "Traceback" not in err
    assert sorted(parts.iterdir()) == before


@pytest.mark.parametrize("vertices", [479, 481, 2**31 - 1])
def test_forged_vertices_are_refused(command, parts, vertices):  # noqa: F811
    """Both records agree, and their checksums match their files, whose heads and sizes are of 480 vertices."""
    for number in (1, 2):
        change(parts / f"Arm.{number}-of-2.pc2.json", {"job.vertices": vertices})
    code, _out, err = command("merge", parts)
    assert code == 3 and "was changed after it was written" in err and not (parts / "Arm.pc2").exists()


def test_a_changed_or_renamed_record_is_refused(command, parts):  # noqa: F811
    record = parts / "Arm.1-of-2.pc2.json"
    before = record.read_text()
    change(record, {"job.scene": "Other"}, keep_fingerprint=True)
    assert "was changed after it was written" in command("merge", parts)[2]
    record.write_text(before)
    record.rename(parts / "Leg.1-of-2.pc2.json")
    code, _out, err = command("merge", parts)
    assert code == 3 and "belongs to Arm.1-of-2.pc2.json" in err


def test_other_files_in_the_folder_are_not_read(command, parts):  # noqa: F811
    (parts / "scene.json").write_text("[" * 100_000)
    (parts / "settings.json").write_text('{"sinew_chunk": 7}')
    assert command("merge", parts)[0] == 0


@pytest.mark.parametrize("text", ["[" * 100_000, "", "{}", '{"sinew_chunk": 1', '{"sinew_chunk": 2}', "x" * 30_000])
def test_a_file_with_the_name_of_a_record_is_refused_in_time(tmp_path, text):
    (tmp_path / "Arm.1-of-2.pc2.json").write_text(text)
    begin = time.process_time()
    with pytest.raises(SinewError, match="Arm.1-of-2.pc2.json"):
        chunk_records.records_in(tmp_path)
    assert time.process_time() - begin < 0.1


def test_a_file_that_a_record_names_is_not_opened(command, saved, parts, tmp_path):  # noqa: F811
    """Whoever can write to the folder could name a file with scripts there, and farms start Blender with -y."""
    other = tmp_path / "other.blend"
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.ops.wm.save_as_mainfile(filepath=str(other))
    for number in (1, 2):
        change(parts / f"Arm.{number}-of-2.pc2.json", {"blend": str(other)})
    bpy.ops.wm.open_mainfile(filepath=str(saved[0]))
    code, _out, err = command("merge", parts, "--blend", tmp_path / "out.blend")
    assert code == 2 and "--blend requires --file" in err
    assert command("merge", parts, "--blend", tmp_path / "out.blend", "--file", saved[0])[0] == 0
    assert bpy.data.filepath == str(saved[0])


def test_a_blend_that_fails_leaves_no_joined_cache(command, saved, parts, tmp_path):  # noqa: F811
    before = sorted(parts.iterdir())
    out = tmp_path / "taken"
    out.mkdir()
    code, _out, err = command("merge", parts, "--blend", out, "--file", saved[0])
    assert code == 4 and "is a folder" in err and sorted(parts.iterdir()) == before
    bpy.data.objects["Arm"].name = "Leg"
    bpy.ops.wm.save_mainfile()
    code, _out, err = command("merge", parts, "--blend", tmp_path / "out.blend", "--file", saved[0])
    assert code == 3 and "has changed since Arm was baked" in err and sorted(parts.iterdir()) == before
