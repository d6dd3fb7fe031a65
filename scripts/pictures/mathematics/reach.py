"""The figure of docs/mathematics/reach.md."""

import _sinew
import numpy as np

from pictures.mathematics.bodies import translation
from pictures.mathematics.canvas import BLUE, GREY, RED, figure, plain, save


def draw_reach():
    drawing, axes = figure(8.4, 2.9, 3)
    goal, far = (0.0, 0.45, 0.55), (0.0, 1.1, 0.6)
    cases = (
        ("a goal within reach", goal, None),
        ("first two joints at eagerness 0.2", goal, np.array([0.2, 0.2, 1.0, 1.0])),
        ("a goal out of reach", far, None),
    )
    for axis, (label, target, eagerness) in zip(axes, cases, strict=True):
        count, length = 4, 0.25
        sockets = np.stack([np.eye(4)] + [translation(0, length, 0)] * (count - 1))
        limits = np.full((count, 3), 2.5)
        flat = np.array([1.0, 0.0, 0.0])
        ik_chain = _sinew.Linkage(
            [f"{joint}" for joint in range(count)],
            np.arange(-1, count - 1, dtype=np.int32),
            np.ascontiguousarray(np.swapaxes(sockets, 1, 2)),
            ["XYZ"] * count,
            np.tile([0.15, 0.0, 0.0], (count, 1)),
            -limits * flat,
            limits * flat,
            eagerness=eagerness,
        )
        position_goal = _sinew.Goal(count - 1, "POSITION", target, point=(0, length, 0))
        solution = _sinew.reach(ik_chain, [position_goal])
        for angles, colour in ((ik_chain.angles, GREY), (solution.angles, BLUE)):
            heads = ik_chain.heads(angles)
            bend = angles[:, 0].sum()
            tip = heads[-1] + length * np.array([0, np.cos(bend), np.sin(bend)])
            line = np.vstack([heads, tip])
            axis.plot(line[:, 1], line[:, 2], "o-", color=colour, markersize=4)
        axis.plot(target[1], target[2], "x", color=RED, markersize=8)
        axis.set_title(label, fontsize=9)
        axis.set(xlim=(-0.1, 1.2), ylim=(-0.1, 0.9))
        plain(axis)
        print(f"  {label}: residual {1000 * solution.misses[0]:.3f} mm, {solution.evaluations} evaluations")
    save(drawing, "reach")
