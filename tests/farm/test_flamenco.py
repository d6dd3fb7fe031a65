# SPDX-License-Identifier: GPL-3.0-or-later
"""The Flamenco job type: compiled under node with a stub of Flamenco, and its tasks run."""

import json
import shutil
import subprocess
from pathlib import Path

import pytest
from conftest import ROOT

JOB_TYPE = ROOT / "farm/flamenco/sinew_bake.js"
STUB = Path(__file__).parent / "flamenco_stub.js"
NODE = shutil.which("node")

pytestmark = pytest.mark.skipif(
    NODE is None, reason="NOT TESTED: node is not installed, which compiles the Flamenco job type"
)


@pytest.fixture
def compile_job(tmp_path):
    def compile_job(**settings):
        path = tmp_path / "settings.json"
        defaults = {"object": "An Arm", "frames": "1-250", "blendfile": "/a b.blend", "output_folder": "/out"}
        path.write_text(json.dumps(defaults | settings))
        return subprocess.run([NODE, STUB, JOB_TYPE, path], capture_output=True, text=True, timeout=60)

    return compile_job


def tasks_of(done):
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)["tasks"]


def test_each_chunk_is_a_task_and_a_last_task_waits_for_all(compile_job):
    *bakes, merge = tasks_of(compile_job())
    assert [task["name"] for task in bakes] == [f"bake-{number}-of-5" for number in range(1, 6)]
    assert merge["dependencies"] == [task["name"] for task in bakes] and not any(task["dependencies"] for task in bakes)
    assert {task["type"] for task in (*bakes, merge)} == {"blender"}
    (command,) = bakes[1]["commands"]
    assert command["name"] == "blender-render"
    assert command["parameters"] == {
        "exe": "{blender}",
        "exeArgs": "{blenderArgs}",
        "argsBefore": [],
        "blendfile": "/a b.blend",
        "args": [
            "--command", "sinew", "bake", "/a b.blend", "--object=An Arm", "--frames=1..250", "--step=1",
            "--chunk=2/5", "--format=pc2", "--points=before-armature", "--output=/out",
        ],
    }  # fmt: skip


def test_a_name_that_begins_with_a_dash_is_no_option(compile_job):
    for task in tasks_of(compile_job(object="-y")):
        assert "--object=-y" in task["commands"][0]["parameters"]["args"]


@pytest.mark.parametrize(
    ("settings", "chunks", "frames"),
    [
        ({"frames": "7"}, 1, "7..7"),
        ({"frames": "-10..40", "chunk_size": 17}, 3, "-10..40"),
        ({"frames": "-10--2", "chunk_size": 3}, 3, "-10..-2"),
        ({"frames": " 1 - 100 ", "step": 10, "chunk_size": 3}, 4, "1..100"),
        ({"frames": "1-3", "chunk_size": 1}, 3, "1..3"),
    ],
)
def test_frames_and_chunks(compile_job, settings, chunks, frames):
    *bakes, _merge = tasks_of(compile_job(**settings))
    assert len(bakes) == chunks and f"--frames={frames}" in bakes[0]["commands"][0]["parameters"]["args"]


@pytest.mark.parametrize(
    ("settings", "words"),
    [
        ({"frames": "1,5-10"}, "is not a range"),
        ({"frames": "9-1"}, "before the first"),
        ({"frames": ""}, "is not a range"),
        ({"step": 0}, "must be 1 or more"),
        ({"chunk_size": 0}, "must be 1 or more"),
    ],
)
def test_bad_settings_are_refused_before_anything_runs(compile_job, settings, words):
    done = compile_job(**settings)
    assert done.returncode != 0 and words in done.stderr


def test_settings_have_types_that_flamenco_knows(compile_job):
    for setting in json.loads(compile_job().stdout)["settings"]:
        assert setting["type"] in ("string", "int32", "float", "bool")
        assert setting.get("subtype", "dir_path") in ("file_path", "dir_path", "file_name", "hashed_file_path")
        assert setting.get("visible", "visible") in ("visible", "hidden", "submission", "web")
        assert set(setting) <= {
            "key", "type", "subtype", "choices", "propargs", "description", "default", "eval", "evalInfo", "visible",
            "required", "editable",
        }  # fmt: skip


def test_the_tasks_give_the_same_bytes_as_one_bake(compile_job, blender, arm_file, whole, tmp_path):
    """The test runs the tasks as a worker does: {blender} and {blenderArgs} are replaced, and the file comes first."""
    out = tmp_path / "out"
    done = compile_job(frames="3-38", step=5, chunk_size=4, blendfile=str(arm_file), output_folder=str(out))
    for task in tasks_of(done):
        parameters = task["commands"][0]["parameters"]
        command = [str(blender), "-b", "-y", parameters["blendfile"], *parameters["args"]]
        assert subprocess.run(command, capture_output=True, timeout=600).returncode == 0
    assert (out / "An Arm.pc2").read_bytes() == whole
