# SPDX-License-Identifier: GPL-3.0-or-later
"""The random walk: after each step no traceback, finite points, and the session equals a fresh evaluation of the file."""

import bpy
import numpy as np
import pytest
from bl_ext.user_default.sinew.live import session
from checker import Complaints, check, shown
from conftest import FLEXOR, add_muscle, bend, bind, make_arm
from walk import STEPS, walk

STEPS_IN_CI, SEEDS_IN_CI = 120, (1, 7)


@pytest.mark.parametrize("seed", SEEDS_IN_CI)
def test_a_short_walk(tmp_path, seed):
    walk(seed, STEPS_IN_CI, tmp_path)


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(10, 15))
def test_a_long_walk(tmp_path, seed):
    counts = walk(seed, 10_000, tmp_path)
    assert counts.keys() == {step.__name__ for step, _weight in STEPS}


@pytest.fixture
def bent():
    skin, rig = make_arm()
    add_muscle(rig, around=FLEXOR)
    bind(skin)
    bend(rig, 1.2)
    return skin, rig


def test_the_checker_finds_a_stale_bind(bent):
    skin, _rig = bent
    assert check() == []
    state = session.cached_skin(skin)
    state.correction[:] += 0.001
    state.written_sample = None
    before = shown()[0][skin.name]
    skin.data.attributes["sinew_correction"].data.foreach_set("vector", state.correction.reshape(-1))
    assert not np.array_equal(shown()[0][skin.name], before)
    assert any("off a fresh evaluation" in wrong for wrong in check())


def test_the_checker_finds_another_reason_and_points_that_are_not_finite(bent):
    skin, _rig = bent
    session.set_reason(skin, "made up")
    assert any("made up" in wrong for wrong in check())
    skin.data.vertices[0].co.x = float("nan")
    assert not any("not finite" in wrong for wrong in check())  # without Sinew it is not finite either
    skin.data.vertices[0].co.x = 0.0
    check()
    skin.data.attributes["sinew_correction"].data[0].vector = (float("nan"), 0.0, 0.0)
    assert any("not finite" in wrong for wrong in check())


def test_tracebacks_are_collected(bent):
    def fail(*_):
        raise ZeroDivisionError("on purpose")

    bpy.app.handlers.depsgraph_update_post.append(fail)
    try:
        with Complaints() as complaints:
            bend(bent[1], 0.2)
            assert "on purpose" in complaints.take() and complaints.take() == ""
    finally:
        bpy.app.handlers.depsgraph_update_post.remove(fail)
