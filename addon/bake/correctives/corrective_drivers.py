# SPDX-License-Identifier: GPL-3.0-or-later
"""Drives the value of a corrective by tent weights: 1 at the key's angle, 0 at the angles of its neighbours and at rest.

Each variable reads the swing and twist of one bone in its local space, after its constraints. No driver runs Python, so
correctives work with Auto Run Python Scripts off, and an exporter can find the bone. `joint_turns` describes the
angles.
"""

from dataclasses import dataclass

from ..scratch.joint_turns import AXES, JointTurn

_CHANNELS = {"X": "ROT_X", "Y": "ROT_Y", "Z": "ROT_Z"}


@dataclass(frozen=True)
class TentWeight:
    """A weight over the angle of a joint turn, linear between its corners.

    It is 1 at `peak` and 0 at `inner`, towards the rest pose, and at `outer`. Where outer is None, it stays 1 beyond
    the peak.
    """

    turn: JointTurn
    inner: float
    peak: float
    outer: float | None


def tent_at(turn: JointTurn, angles: list[float], index: int) -> TentWeight:
    """Returns the tent weight of one key of a turn. angles: those of all its keys, increasing; none is 0, the rest pose."""
    peak = angles[index]
    beside = (angles[index - 1] if index else None), (angles[index + 1] if index + 1 < len(angles) else None)
    inner, outer = beside if peak > 0.0 else reversed(beside)
    return TentWeight(turn, inner if inner is not None and inner * peak > 0.0 else 0.0, peak, outer)


def drive(key, rig, tents: list[TentWeight]):
    """Gives a shape key's value a driver that computes the product of tent weights."""
    curve = key.driver_add("value")
    driver = curve.driver
    driver.type = "SCRIPTED"
    names: dict[tuple[str, str], str] = {}
    driver.expression = "*".join(_expression(tent, names) for tent in tents)
    for (bone, axis), name in names.items():
        variable = driver.variables.new()
        variable.name, variable.type = name, "TRANSFORMS"
        target = variable.targets[0]
        target.id, target.bone_target = rig, bone
        target.transform_type, target.transform_space = _CHANNELS[axis], "LOCAL_SPACE"
        target.rotation_mode = "SWING_TWIST_Y"


def _expression(tent: TentWeight, names: dict[tuple[str, str], str]) -> str:
    """Returns a tent weight as an expression and adds the variables that it needs to `names`, (bone, axis) to name."""
    turn = tent.turn
    if turn.axis in AXES:
        angle = _variable(turn.bone, turn.axis, names)
    else:
        x, z = (_variable(turn.bone, axis, names) for axis in "XZ")
        angle = f"2*asin({turn.direction[0]:.6g}*sin({x}/2){turn.direction[2]:+.6g}*sin({z}/2))"
    rise = _line(angle, tent.inner, tent.peak)
    if tent.outer is None:
        return f"clamp({rise})"
    return f"max(0,min({rise},{_line(angle, tent.outer, tent.peak)}))"


def _line(angle: str, zero: float, one: float) -> str:
    """Returns the linear function of an angle that is 0 at `zero` and 1 at `one`."""
    return f"({angle}{-zero:+.7g})*{1.0 / (one - zero):.7g}" if zero else f"({angle})*{1.0 / one:.7g}"


def _variable(bone: str, axis: str, names: dict[tuple[str, str], str]) -> str:
    return names.setdefault((bone, axis), "abcdefgh"[len(names)])
