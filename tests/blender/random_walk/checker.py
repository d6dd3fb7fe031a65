# SPDX-License-Identifier: GPL-3.0-or-later
"""Compares what the session shows with a fresh evaluation of the same file, and collects tracebacks.

`check` can be called by any test, after any edit. The session goes on as it was.
"""

import logging
import sys

import bpy
import numpy as np
from bl_ext.user_default.sinew.live import failures, handlers, session
from bl_ext.user_default.sinew.scene import characters
from conftest import points_of_evaluated

# a bind is kept while the mesh moves by rounding only, so the session may differ from a new bind by that
ROUNDING_OF_SIZE = 2e-5


class Complaints(logging.Handler):
    """Collects tracebacks: those that Python prints, and those that Sinew logs. Use it in a `with` statement."""

    def __init__(self):
        super().__init__(logging.ERROR)
        self.texts: list[str] = []

    def emit(self, record):
        self.texts.append(logging.Formatter().format(record))

    def write(self, text):
        self._printed += text
        return self._before.write(text)

    def flush(self):
        self._before.flush()

    def __enter__(self):
        self._printed, self._before = "", sys.stderr
        sys.stderr = self
        logging.getLogger("sinew").addHandler(self)
        return self

    def __exit__(self, *_):
        sys.stderr = self._before
        logging.getLogger("sinew").removeHandler(self)

    def take(self) -> str:
        """All tracebacks since the last call, or an empty text."""
        texts, printed = self.texts, self._printed
        self.texts, self._printed = [], ""
        return "\n".join([*texts, printed] if "Traceback" in printed else texts)


def shown() -> tuple[dict[str, np.ndarray], dict[str, str]]:
    """The points of all mesh objects of the view layer that Blender evaluates, and the reasons of their skins, by name."""
    bpy.context.view_layer.update()
    depsgraph = bpy.context.evaluated_depsgraph_get()
    points, reasons = {}, {}
    for found in bpy.context.view_layer.objects:
        evaluated = found.evaluated_get(depsgraph)
        if found.type == "MESH" and evaluated.is_evaluated and not found.data.is_editmode:
            points[found.name_full] = points_of_evaluated(evaluated)
            # while the armature is in Edit Mode, its skins keep what they had
            rig = characters.rig_or_none(found)
            reasons[found.name_full] = "" if rig and rig.data.is_editmode else session.reason(found)
    return points, reasons


def shown_afresh() -> tuple[dict[str, np.ndarray], dict[str, str]]:
    """As `shown`, after everything was read from the file again. Restores the session."""
    kept = dict(session._rigs), dict(session._skins), dict(session._reasons)
    index, failed, is_dirty = characters._index, dict(failures._failures), handlers._is_all_dirty
    handlers._start_over()
    handlers._evaluate_windows()
    fresh = shown()
    for cache, before in zip((session._rigs, session._skins, session._reasons), kept):
        cache.clear()
        cache.update(before)
    characters._index, handlers._is_all_dirty = index, is_dirty
    failures._failures.clear()
    failures._failures.update(failed)
    return fresh


def check() -> list[str]:
    """What is wrong: meshes that are not finite, or that differ from a fresh evaluation. One sentence each."""
    points, reasons = shown()
    wrong = [
        f"{name} is not finite" for name, own in points.items() if not np.isfinite(own).all() and _is_finite_alone(name)
    ]
    fresh, fresh_reasons = shown_afresh()
    wrong += compare(points, reasons, fresh, fresh_reasons)
    return wrong


def _is_finite_alone(name: str) -> bool:
    """Whether a mesh is finite without Sinew. Blender itself makes NaN of bones with a scale of 0."""
    found = next(found for found in bpy.context.view_layer.objects if found.name_full == name)
    modifier = found.modifiers.get("Sinew")
    if modifier is None or not modifier.show_viewport:
        return False
    modifier.show_viewport = False
    alone = shown()[0][name]
    modifier.show_viewport = True
    bpy.context.view_layer.update()
    return bool(np.isfinite(alone).all())


def compare(points: dict, reasons: dict, fresh: dict, fresh_reasons: dict) -> list[str]:
    """The differences of two results of `shown`, one sentence each."""
    wrong = [f"{name} is only in one of both" for name in points.keys() ^ fresh.keys()]
    for name in points.keys() & fresh.keys():
        own, other = points[name], fresh[name]
        if reasons[name] != fresh_reasons[name]:
            wrong.append(f"{name}: the reason is '{reasons[name]}', afresh '{fresh_reasons[name]}'")
        if own.shape != other.shape:
            wrong.append(f"{name} has {len(own)} points, afresh {len(other)}")
        elif len(own):
            size = max(float(np.nanmax(np.abs(other))), 1.0)
            distance = float(np.nan_to_num(np.abs(own - other), nan=0.0).max())
            if distance > ROUNDING_OF_SIZE * size:
                wrong.append(f"{name} is {1000.0 * distance:.4f} mm off a fresh evaluation")
    return wrong
