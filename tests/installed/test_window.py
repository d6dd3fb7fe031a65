# SPDX-License-Identifier: GPL-3.0-or-later
"""The built extension in a real Blender with a window: every operator from its button, every modal by events.

pip's bpy has no window. SINEW_REAL_BLENDER names a program that starts a Blender with a window (or a virtual screen) in the
current folder and passes on its arguments; without it, these tests are skipped.
"""

import json
import os
import shlex
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
PROGRAM = os.environ.get("SINEW_REAL_BLENDER", "")

pytestmark = pytest.mark.skipif(
    not PROGRAM, reason="NOT TESTED: no Blender with a window. Set SINEW_REAL_BLENDER to a program that starts one"
)


@pytest.fixture(scope="module")
def happened(tmp_path_factory):
    """What smoke.py wrote, and everything that Blender printed."""
    folder = tmp_path_factory.mktemp("window")
    build = [sys.executable, ROOT / "scripts/build_extension.py"]
    archive = Path(subprocess.run(build, check=True, stdout=subprocess.PIPE, text=True).stdout.strip())
    for file in (archive, Path(__file__).with_name("smoke.py")):
        shutil.copy(file, folder)
    command = [*shlex.split(PROGRAM), "--enable-event-simulate", "--factory-startup", "--python", "smoke.py", "--"]
    done = subprocess.run(
        [*command, archive.name, "result.json"], cwd=folder, capture_output=True, text=True, errors="replace", timeout=900
    )
    output = done.stdout + done.stderr
    assert (folder / "result.json").is_file(), output[-4000:]
    return json.loads((folder / "result.json").read_text()), output


def test_every_operator_is_invoked_and_ends(happened):
    results, _output = happened
    (end,) = [result for result in results if not result["operator"]]
    assert end["how"] == "all", end
    confirmed = {result["operator"] for result in results if result["how"] == "confirmed"}
    assert len(confirmed) == end["count"] >= 29


def test_no_operator_prints_a_traceback(happened):
    _results, output = happened
    assert "Traceback" not in output, output[output.index("Traceback") - 500 :][:4000]


def test_bakes_have_an_effect_and_restore_frame_and_mode(happened):
    results, _output = happened
    baked = [result for result in results if result["how"] == "baked"]
    assert len(baked) == 4 and [result for result in baked if result["wrong"]] == []


def test_modals_that_are_ended_with_esc_change_nothing(happened):
    results, _output = happened
    escaped = [result for result in results if result["how"] == "escaped"]
    assert len(escaped) == 6 and [result for result in escaped if result["wrong"]] == []
    assert {result["operator"] for result in escaped if result["was running"]} >= {"bake_shape_keys", "reach"}
