# SPDX-License-Identifier: GPL-3.0-or-later
"""A seeded random walk over everything that a user or a script can do, with a check after each step."""

from pathlib import Path

import bpy
import edits
import file_steps
import operator_steps
from checker import Complaints, check
from world import Nothing, World

STEPS = (*edits.STEPS, *file_steps.STEPS, *operator_steps.STEPS)
HISTORY = 40  # steps that a failure prints


class Wrong(AssertionError):
    """A step after which something is wrong."""


def walk(seed: int, steps: int, folder: Path) -> dict[str, int]:
    """Walks and returns how often each step did something. Raises Wrong with the seed, the number and the last steps."""
    world, history, counts = World(seed, folder), [], {}
    world.build()
    choices, weights = zip(*STEPS, strict=True)
    with Complaints() as complaints:
        for number in range(steps):
            (step,) = world.random.choices(choices, weights)
            history.append(step.__name__)
            try:
                wrong = _take(world, step, counts)
            except AssertionError as error:
                wrong = [str(error)]
            traceback = complaints.take()
            if traceback:
                wrong.append(traceback)
            if wrong:
                last = ", ".join(history[-HISTORY:])
                raise Wrong(f"seed {seed}, step {number}: {step.__name__}: {'; '.join(wrong)}\nthe last steps: {last}")
    return counts


def _take(world: World, step, counts: dict[str, int]) -> list[str]:
    try:
        step(world)
    except Nothing:
        return []
    except RuntimeError as error:  # Blender refused: its operators can't edit linked objects, for example
        if "Traceback" in str(error):
            return [str(error)]
    counts[step.__name__] = counts.get(step.__name__, 0) + 1
    if step not in file_steps.WITHOUT_PUSH:
        bpy.ops.ed.undo_push(message=step.__name__)  # as Blender does after each operator in a window
    return check()
