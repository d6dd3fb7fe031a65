# SPDX-License-Identifier: GPL-3.0-or-later
"""A bake that is killed leaves the old file, and the next bake removes its unfinished file."""

import random
import subprocess
import sys
import time
from pathlib import Path

import bpy
import pytest
from bl_ext.user_default.sinew.bake.cache import point_cache

SCRIPTS = Path(__file__).resolve().parents[2] / "scripts"
MANY, FEW = 3000, 100


@pytest.fixture
def start(waving, tmp_path):
    """Starts a bake of many frames in another Blender. Frames after 12 hold the last pose."""
    path = tmp_path / "arm.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(path))

    def start(frames, output):
        command = [sys.executable, "-u", SCRIPTS / "build/inside_blender.py", SCRIPTS / "build/command_in_blender.py"]
        command += ["--command", "sinew", "bake", path, "--object", "Arm", "--output", output, "--frames"]
        return subprocess.Popen([*map(str, command), f"{frames[0]}..{frames[-1]}"], stderr=subprocess.PIPE, text=True)

    return start


def wait_for(process, words):
    for line in process.stderr:
        if words in line:
            return
    raise AssertionError("ended too early")


def finish(process):
    process.stderr.read()
    assert process.wait() == 0


@pytest.mark.parametrize("rounds", [1, pytest.param(30, marks=pytest.mark.slow)])
def test_a_bake_killed_at_any_moment_keeps_the_old_file(start, tmp_path, rounds):
    out = tmp_path / "out"
    finish(start(range(1, FEW), out))
    path = out / "Arm.pc2"
    old = path.read_bytes()
    chance = random.Random(rounds)
    left = 0
    for _ in range(rounds):
        process = start(range(5, MANY), out)
        wait_for(process, "baking")
        time.sleep(chance.uniform(0.0, 0.3))
        process.kill()
        process.wait()
        assert path.read_bytes() == old
        left = max(left, len(list(out.iterdir())) - 1)
        assert len(list(out.iterdir())) <= 2, "the next bake did not remove the unfinished file of a killed one"
    assert left, "no bake was killed while it wrote"
    finish(start(range(5, FEW), out))
    assert list(out.iterdir()) == [path] and point_cache.read(path, "PC2").frame_start == 5.0


@pytest.mark.parametrize("rounds", [1, pytest.param(30, marks=pytest.mark.slow)])
def test_a_bake_killed_at_its_end_leaves_one_complete_file(start, tmp_path, rounds):
    out = tmp_path / "out"
    chance = random.Random(rounds)
    for number in range(rounds):
        process = start(range(number, number + FEW), out)
        wait_for(process, "100%")
        time.sleep(chance.uniform(0.0, 0.01))
        process.kill()
        process.wait()
        if (out / "Arm.pc2").exists():
            assert point_cache.read(out / "Arm.pc2", "PC2").samples.shape == (FEW, 480, 3)
