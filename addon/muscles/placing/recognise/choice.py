# SPDX-License-Identifier: GPL-3.0-or-later
"""Which muscles a creature gets: the preset of its kind, or automatic muscles at its joints."""

from .kind import BIRD, FISH, HUMAN, QUADRUPED

# An insect's shell keeps its shape, so its muscles do not show: it gets the automatic ones, as other creatures do.
PRESET_OF_KIND = {HUMAN: "human", QUADRUPED: "quadruped", BIRD: "bird", FISH: "fish"}


def preset_of(kind: str) -> str:
    """The preset for a kind of creature, or "" for automatic muscles. kind: of `kind.KINDS`."""
    return PRESET_OF_KIND.get(kind, "")


def proposal(kind: str) -> str:
    """What to add instead, for a message: "the preset quadruped, or Add Muscles to Joints"."""
    preset = preset_of(kind)
    return f"the preset {preset}, or Add Muscles to Joints" if preset else "Add Muscles to Joints"
