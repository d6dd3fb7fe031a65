# SPDX-License-Identifier: GPL-3.0-or-later
"""Fixtures for tests of render farms: a file to bake, and a program that replaces Blender."""

import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "scripts"))

SCENE = """
import sys
import bpy

sys.path.insert(0, sys.argv[1])
import conftest

bpy.ops.wm.read_factory_settings(use_empty=True)
skin, rig = conftest.make_arm()
conftest.add_muscle(rig, around=conftest.FLEXOR)
bone = rig.pose.bones["lower"]
bone.rotation_mode = "XYZ"
for frame, angle in ((1, 0.0), (40, 1.4)):
    bone.rotation_euler[2] = angle
    bone.keyframe_insert("rotation_euler", frame=frame)
conftest.bind(skin)
skin.name = "An Arm"
bpy.ops.wm.save_as_mainfile(filepath=sys.argv[2])
"""


@pytest.fixture(scope="session")
def blender(tmp_path_factory):
    """The path of a program that takes the arguments of Blender that farms use."""
    path = tmp_path_factory.mktemp("program") / "blender"
    run, script = ROOT / "scripts/run_in_blender.py", ROOT / "scripts/build/command_in_blender.py"
    path.write_text(f'#!/bin/sh\nexec "{sys.executable}" "{run}" "{script}" "$@"\n')
    path.chmod(0o755)
    return path


@pytest.fixture(scope="session")
def arm_file(tmp_path_factory):
    """A file with the bound mesh "An Arm", which bends over frames 1 to 40."""
    folder = tmp_path_factory.mktemp("scene of a farm")
    script, path = folder / "scene.py", folder / "an arm.blend"
    script.write_text(SCENE)
    run = [sys.executable, ROOT / "scripts/run_in_blender.py", script, ROOT / "tests/blender", path]
    subprocess.run(list(map(str, run)), check=True, capture_output=True, timeout=600)
    return path


@pytest.fixture(scope="session")
def whole(blender, arm_file, tmp_path_factory):
    """The bytes of the point cache of every fifth frame from 3 to 38, baked in one process."""
    folder = tmp_path_factory.mktemp("whole")
    command = [blender, "--command", "sinew", "bake", arm_file, "--object", "An Arm", "--frames", "3..38", "--step", "5"]
    subprocess.run(list(map(str, (*command, "--output", folder))), check=True, capture_output=True, timeout=600)
    return (folder / "An Arm.pc2").read_bytes()
