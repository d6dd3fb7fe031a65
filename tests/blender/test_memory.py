# SPDX-License-Identifier: GPL-3.0-or-later
"""Playing, scrubbing, undo and redo do not make the process grow."""

import os
from pathlib import Path

import bpy
import pytest
from conftest import bend

FRAMES, UNDO_STEPS = 3000, 500
LARGEST_GROWTH_MB = 5.0


def resident_mb() -> float:
    pages = int(Path("/proc/self/statm").read_text().split()[1])
    return pages * os.sysconf("SC_PAGE_SIZE") / 1e6


@pytest.mark.slow
@pytest.mark.skipif(not Path("/proc/self/statm").exists(), reason="reads the memory of a process on Linux")
def test_frames_and_undo_steps_do_not_grow(waving):
    _skin, rig = waving

    def play(frames: int):
        for frame in range(frames):
            bpy.context.scene.frame_set(1 + frame % 12)

    def undo(steps: int):
        for step in range(steps):
            bend(bpy.data.objects[name], 0.002 * (step % 50), "upper")
            bpy.ops.ed.undo_push(message="pose")
            if step % 5 == 4:
                bpy.ops.ed.undo()
                bpy.ops.ed.redo()

    name = rig.name
    play(200)
    undo(100)  # fills the undo stack
    before = resident_mb()
    play(FRAMES)
    assert resident_mb() - before <= LARGEST_GROWTH_MB
    undo(UNDO_STEPS)
    assert resident_mb() - before <= LARGEST_GROWTH_MB
