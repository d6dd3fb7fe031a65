# SPDX-License-Identifier: GPL-3.0-or-later
"""How much muscle and fat a body has: the measured volumes of a preset, scaled to a body and its figure.

Muscles of sprinters have 1.22 times the volume per body mass (Handsfield et al., Scand J Med Sci Sports, 2017), which is the
factor of *Strong*. Fat of elite athletes is a third as deep as that of most people (Kelso et al., Sports Medicine, 2020).
The factor of *Lean* and *Strong*, a half, is a choice between the two.
"""

from dataclasses import dataclass

from ....scene.tissue_empty import TissueShape
from ... import portable_names
from .preset_file import Preset, SpanRule

MM, CM3, LITRE = 1e-3, 1e-6, 1e-3


@dataclass(frozen=True)
class Figure:
    """Factors on the measured volumes of muscles and on the depth of fat."""

    identifier: str
    label: str
    description: str
    muscle: float
    fat: float


LEAN = Figure("LEAN", "Lean", "The measured volumes, under half of the fat", 1.0, 0.5)
AVERAGE = Figure("AVERAGE", "Average", "The measured volumes and fat", 1.0, 1.0)
STRONG = Figure("STRONG", "Strong", "Muscles of an athlete, under half of the fat", 1.22, 0.5)
FIGURES = {figure.identifier: figure for figure in (AVERAGE, LEAN, STRONG)}


def measured_volumes(preset: Preset, body_m3: float, figure: Figure) -> dict[str, float]:
    """By name without its side: the volume that each muscle was measured to have, scaled to a body and its figure, m3.

    Of a belly that joins strands, their sum.
    """
    scale = figure.muscle * CM3 * body_m3 / (preset.body_litres * LITRE)
    volumes_m3: dict[str, float] = {}
    for rule in preset.tissues:
        if isinstance(rule, SpanRule) and rule.volume_cm3:
            for name in {rule.name, rule.belly} - {""}:
                volumes_m3[name] = volumes_m3.get(name, 0.0) + scale * rule.volume_cm3
    return volumes_m3


def goals(preset: Preset, shapes: list[TissueShape], body_m3: float, figure: Figure) -> tuple[list[float], list[float]]:
    """The volume that each tissue should have on a body, m3, 0 if none was measured, and the depth of fat over it, m."""
    volumes_m3 = measured_volumes(preset, body_m3, figure)
    longer = (body_m3 / (preset.body_litres * LITRE)) ** (1 / 3)
    fat_m = {}
    for rule in preset.tissues:
        fat_m[rule.name] = longer * figure.fat * preset.fat_mm[rule.group] * MM
        if isinstance(rule, SpanRule) and rule.belly:
            fat_m[rule.belly] = fat_m[rule.name]
    names = [portable_names.without_side(shape.name) for shape in shapes]
    return [volumes_m3.get(name, 0.0) for name in names], [fat_m[name] for name in names]
