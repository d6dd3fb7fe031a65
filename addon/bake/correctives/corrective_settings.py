# SPDX-License-Identifier: GPL-3.0-or-later
"""The settings of a bake of correctives."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Settings:
    """Which joints are baked, over which angles, and how closely.

    joints: the bones whose heads are the joints; None: all joints that muscles cross.
    all_joints: instead, all joints whose correction exceeds the tolerance.
    angles: texts for `turn_ranges.parse_ranges`, one for each joint or one for all; empty: from the bones' limits.
    twists: whether joints also twist where `angles` is empty.
    tolerance_mm: the largest error in the world.
    threshold_mm: shorter displacements in a key become 0.
    max_keys_per_turn: takes precedence over the tolerance; 0: no limit.
    max_keys_per_pair: for each of the four quadrants of two joint turns; 0: no pairs.
    prefix: the beginning of the keys' names.
    """

    joints: list[str] | None
    all_joints: bool
    angles: list[str]
    twists: bool
    tolerance_mm: float
    threshold_mm: float
    max_keys_per_turn: int
    max_keys_per_pair: int
    prefix: str

    def mesh_lengths(self, mm_per_metre: float) -> tuple[float, float]:
        """Tolerance and threshold in mesh space. mm_per_metre: see `key_store.mm_per_metre`."""
        return self.tolerance_mm / mm_per_metre, self.threshold_mm / mm_per_metre
