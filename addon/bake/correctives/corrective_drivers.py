# SPDX-License-Identifier: GPL-3.0-or-later
"""Drivers that let a corrective act by its tents: 1 at its own angle, 0 at the neighbouring keys and at rest.

Each variable reads one bone, in its own space, after its constraints, as swing and twist; none reads an object or runs Python, so
they work with Auto Run Python Scripts off, and an exporter finds the bone. See `motions` for the angle.
"""

from dataclasses import dataclass

from ..scratch.joint_turns import AXES, Motion

_CHANNELS = {"X": "ROT_X", "Y": "ROT_Y", "Z": "ROT_Z"}
LONGEST_EXPRESSION = 255  # of Blender's


@dataclass(frozen=True)
class TentWeight:
    """Where a key of a motion acts: fully at `peak`; not any more at `inner` (towards rest) and `outer` (None: it stays)."""

    motion: Motion
    inner: float
    peak: float
    outer: float | None


def tent_at(motion: Motion, at: list[float], place: int) -> TentWeight:
    """The tent of one of a motion's keys, which stand `at` rising values on both sides of rest, 0, or on one."""
    peak = at[place]
    beside = (at[place - 1] if place else None), (at[place + 1] if place + 1 < len(at) else None)
    inner, outer = beside if peak > 0.0 else reversed(beside)
    return TentWeight(motion, inner if inner is not None and inner * peak > 0.0 else 0.0, peak, outer)


def drive(key, rig, tents: list[TentWeight]):
    """Gives a shape key's value the driver that is the product of tents."""
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
    """A tent over the variables `names`, of (bone, axis), where those that it needs and are not there yet are added."""
    motion = tent.motion
    if motion.axis in AXES:
        angle = _variable(motion.bone, motion.axis, names)
    else:
        x, z = (_variable(motion.bone, axis, names) for axis in "XZ")
        angle = f"2*asin({motion.along[0]:.6g}*sin({x}/2){motion.along[2]:+.6g}*sin({z}/2))"
    rise = _line(angle, tent.inner, tent.peak)
    if tent.outer is None:
        return f"clamp({rise})"
    return f"max(0,min({rise},{_line(angle, tent.outer, tent.peak)}))"


def _line(angle: str, zero: float, one: float) -> str:
    """The line over an angle that is 0 at one value and 1 at another."""
    return f"({angle}{-zero:+.7g})*{1.0 / (one - zero):.7g}" if zero else f"({angle})*{1.0 / one:.7g}"


def _variable(bone: str, axis: str, names: dict[tuple[str, str], str]) -> str:
    return names.setdefault((bone, axis), "abcdefgh"[len(names)])
