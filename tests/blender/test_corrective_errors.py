# SPDX-License-Identifier: GPL-3.0-or-later
"""The error that a bake of correctives states is at least the error that is seen in the range of a joint."""

import math

import numpy as np
import pytest
from conftest import FLEXOR, add_muscle, bind
from test_correctives import apart_mm, bake, pose


def stated_mm(skin):
    """The largest error in the report of the last bake."""
    lines = skin.sinew.skin.corrective_summary.splitlines()
    return max(float(line.split(" mm between")[0].rsplit(" ", 1)[1]) for line in lines)


def cone(degrees, directions, twist=0.0):
    """Rotations by an angle about axes across the bone, as (axis, degrees) of each of the bone's axes."""
    half = math.sin(0.5 * math.radians(degrees))
    for index in range(directions):
        around = 2.0 * math.pi * (index + 0.3) / directions
        swings = (2.0 * math.asin(half * part) for part in (math.cos(around), math.sin(around)))
        yield [(axis, math.degrees(angle)) for axis, angle in zip("XZ", swings, strict=True)] + [("Y", twist)]


@pytest.mark.parametrize("twist", [0.0, 35.0])
def test_no_pose_of_a_joint_has_a_larger_error_than_stated(arm, twist):
    skin, rig = arm
    for name, around in (("Flexor", FLEXOR), ("Side", FLEXOR + 1.2), ("Back", FLEXOR + 3.0)):
        add_muscle(rig, around=around, name=name)
    bind(skin)
    skin.sinew.skin.muscle_influence = 3.0
    bake(skin, angles=f"X -80..80 Z -80..80{' Y -40..40' if twist else ''}", tolerance=1.0, most_keys=16)
    seen = []
    for turns in cone(75.0, 15, twist):
        pose(rig, *(("lower", axis, degrees) for axis, degrees in turns))
        seen.append(apart_mm(skin))
    assert 0.25 * stated_mm(skin) < max(seen) <= 1.001 * stated_mm(skin)
    assert f"{stated_mm(skin):.2f} mm" in skin.sinew.skin.corrective_summary


def test_a_joint_with_one_rotation_has_one_line(muscled):
    skin, _rig = muscled
    bake(skin)
    assert len(skin.sinew.skin.corrective_summary.splitlines()) == 1
    assert np.isfinite(stated_mm(skin))
