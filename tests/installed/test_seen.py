# SPDX-License-Identifier: GPL-3.0-or-later
"""What a person sees and does: pictures of ten states beside their references, and clicks and drags on every handle.

Slow: software that draws takes minutes. SINEW_REAL_BLENDER is as in test_window.py; it also needs xdotool and ImageMagick.
"""

import os
import shlex
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
PROGRAM = os.environ.get("SINEW_REAL_BLENDER", "")
LONGEST_S = 900

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(
        not PROGRAM, reason="NOT TESTED: no Blender with a window. Set SINEW_REAL_BLENDER to what starts one"
    ),
]


def blender(folder, *arguments):
    """Runs the program in a folder, and returns what it printed."""
    command = [*shlex.split(PROGRAM), *arguments]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, errors="replace", timeout=LONGEST_S)
    return done.stdout + done.stderr


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A folder with the scripts, in whose Blender the extension is installed."""
    folder = tmp_path_factory.mktemp("seen")
    build = [sys.executable, ROOT / "scripts/build_extension.py"]
    archive = Path(subprocess.run(build, check=True, stdout=subprocess.PIPE, text=True).stdout.strip())
    shutil.copy(archive, folder)
    shutil.copytree(ROOT / "scripts/window", folder / "scripts/window")
    printed = blender(folder, "--command", "extension", "install-file", "-r", "user_default", "-e", archive.name)
    assert "nstalled" in printed, printed[-2000:]
    return folder


@pytest.mark.parametrize("script", ["states", "events"])
def test_every_step_holds(folder, script):
    printed = blender(
        folder,
        "--factory-startup",
        "--addons",
        "bl_ext.user_default.sinew",
        "--python",
        f"scripts/window/{script}.py",
        "--",
        "pictures",
    )
    assert "\n0 of" in printed and "steps failed" in printed, printed[-4000:]
