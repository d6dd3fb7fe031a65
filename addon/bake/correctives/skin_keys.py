# SPDX-License-Identifier: GPL-3.0-or-later
"""The correctives that sampling finds for one mesh, before they are written, and a summary of their errors."""

from dataclasses import dataclass, field

import _sinew
import numpy as np

from ..scratch.joint_turns import JointTurn

_ERRORS = ("error_at_mm", "error_between_mm", "error_before_mm")


@dataclass
class JointResult:
    """The number of keys that one mesh needs for one joint turn or for two together, and their largest errors.

    error_at_mm: at the keys' poses. error_between_mm: at all other samples. error_before_mm: for two turns, without their
    combined keys. Errors are distances on the posed skin in the world.
    """

    turns: list[JointTurn]
    keys: int
    error_at_mm: float
    error_between_mm: float
    error_before_mm: float = 0.0


@dataclass
class SkinKeys:
    """The keys of one mesh.

    index: of the mesh in the PoseSampler. mm_per_metre: see `key_store.mm_per_metre`. single: the keys of each turn.
    body: the name of the mesh under all layers that this one is worn over, or of itself: layers get keys at the same angles.
    regions: (vertices,) bool, the vertices that the keys of a turn move. pairs: the combined keys of two turns.
    """

    name: str
    index: int
    mm_per_metre: float
    body: str = ""
    single: dict[JointTurn, "_sinew.MotionKeys"] = field(default_factory=dict)
    regions: dict[JointTurn, np.ndarray] = field(default_factory=dict)
    pairs: list[tuple[JointTurn, JointTurn, "_sinew.CombinationKeys"]] = field(default_factory=list)
    results: list[JointResult] = field(default_factory=list)


def summary_of(results: list[JointResult]) -> list[str]:
    """Returns one line for each joint, and one for each pair of joints that needs combined keys."""
    lines = []
    groups: dict[tuple[str, bool], list[JointResult]] = {}
    for result in results:
        bones = " with ".join(dict.fromkeys(turn.bone for turn in result.turns))
        groups.setdefault((bones, len(result.turns) > 1), []).append(result)
    for (bones, is_pair), group in sorted(groups.items(), key=lambda item: item[0][1]):
        keys = sum(result.keys for result in group)
        at, between, before = (max(getattr(result, name) for result in group) for name in _ERRORS)
        title = f"{bones}{' (several rotations at once)' if is_pair and ' with ' not in bones else ''}"
        without = f" ({before:.1f} without)" if is_pair else ""
        lines.append(f"{title}: {keys} keys, {at:.4f} mm at them, {between:.2f} mm between{without}")
    return lines
