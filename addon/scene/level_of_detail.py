# SPDX-License-Identifier: GPL-3.0-or-later
"""How much of a skin an evaluation computes: set apart for viewport and renders, and less far from the camera.

The level depends on the settings, the pose, and the camera of the evaluation alone. So it is the same on each machine of a
farm, and whatever frame came before.
"""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass

from mathutils import Vector

FULL, ANCHORS, ARMATURE = "FULL", "ANCHORS", "ARMATURE"
_ORDER = (FULL, ANCHORS, ARMATURE)

_is_full = False


@dataclass(frozen=True)
class Detail:
    """level: FULL, ANCHORS (without elasticity and contact) or ARMATURE (no correction). iterations: of the relaxation."""

    level: str
    iterations: int


def full(values) -> Detail:
    """The detail of bakes and measurements: everything, with the iterations of renders.

    values: the object that has the settings of a skin in an evaluation (`animated_value.values_of`).
    """
    settings = values.sinew.skin
    return Detail(FULL, settings.render_iterations or settings.iterations)


@contextmanager
def full_detail() -> Iterator[None]:
    """Evaluates all skins in full detail in the block."""
    global _is_full
    before, _is_full = _is_full, True
    try:
        yield
    finally:
        _is_full = before


def of(values, depsgraph, centre: Callable[[], Vector]) -> Detail:
    """The detail of a skin in an evaluation.

    values: as for `full`. centre: gives the position of the character in world space. It is called only if a distance is
    set and the scene has a camera.
    """
    if _is_full:
        return full(values)
    settings = values.sinew.skin
    is_render = depsgraph.mode == "RENDER"
    level = settings.render_detail if is_render else settings.viewport_detail
    iterations = (settings.render_iterations if is_render else 0) or settings.iterations
    return Detail(max(level, _by_distance(settings, depsgraph, centre), key=_ORDER.index), iterations)


def _by_distance(settings, depsgraph, centre: Callable[[], Vector]) -> str:
    camera = depsgraph.scene.camera
    limits = {ANCHORS: settings.elastic_distance, ARMATURE: settings.muscle_distance}
    if camera is None or not any(limits.values()):
        return FULL
    distance = (camera.evaluated_get(depsgraph).matrix_world.translation - centre()).length
    beyond = [level for level, limit in limits.items() if limit and distance > limit]
    return beyond[-1] if beyond else FULL
