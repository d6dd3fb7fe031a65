# SPDX-License-Identifier: GPL-3.0-or-later
"""The table of angles of Bake Correctives: it shows what a bake without it would do, and bakes what is left in it."""

import math

import bpy
import pytest
from bl_ext.user_default.sinew.operators import angle_table
from conftest import select

FAST = {"tolerance": 5.0, "most_keys": 1, "combinations": 0}


def rows_of(rig, skin):
    return [
        {"name": turn.bone, "is_baked": True, "axis": axis_of(turn), "low": turn.low, "high": turn.high}
        for turn in angle_table.turns_of(rig, [skin], None)
    ]


def axis_of(turn):
    return "BEND" if turn.axis == angle_table.BEND else turn.axis


def bake(rig, **settings):
    """The lines of the summary of a bake."""
    select(rig)
    bpy.ops.sinew.bake_correctives(**FAST | settings)
    skin = bpy.data.objects["Arm"]
    return skin.sinew.skin.corrective_summary.splitlines()


def test_the_table_starts_with_what_a_bake_without_it_does(muscled):
    skin, rig = muscled
    rows = rows_of(rig, skin)
    assert rows and {row["name"] for row in rows} == {"lower"}
    assert bake(rig, ranges=rows) == bake(rig)


def test_only_checked_rows_are_baked(muscled):
    skin, rig = muscled
    rows = [row | {"is_baked": row["axis"] != "Y", "high": math.radians(40.0), "low": 0.0} for row in rows_of(rig, skin)]
    summary = bake(rig, ranges=rows)
    assert summary == bake(rig, joints="lower", angles=texts_of(rows))
    assert summary != bake(rig)


def texts_of(rows):
    chosen = [row for row in rows if row["is_baked"]]
    axes = ["" if row["axis"] == "BEND" else f"{row['axis']} " for row in chosen]
    return " ".join(
        f"{axis}{math.degrees(row['low']):.4f}..{math.degrees(row['high']):.4f}" for axis, row in zip(axes, chosen)
    )


def test_a_table_without_a_checked_row_is_refused(muscled):
    skin, rig = muscled
    with pytest.raises(RuntimeError, match="No rotation is chosen"):
        bake(rig, ranges=[row | {"is_baked": False} for row in rows_of(rig, skin)])


def test_a_bone_that_is_gone_is_named(muscled):
    _skin, rig = muscled
    with pytest.raises(RuntimeError, match="no bone 'gone'"):
        bake(rig, ranges=[{"name": "gone", "is_baked": True, "axis": "X", "low": 0.0, "high": 1.0}])
