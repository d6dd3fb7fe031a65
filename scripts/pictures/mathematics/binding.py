"""The figures of docs/mathematics/binding.md."""

import _sinew
import numpy as np

from pictures.mathematics.bodies import Tube
from pictures.mathematics.canvas import BLUE, GREY, ORANGE, RED, figure, plain, save


def draw_nearest():
    drawing, (plane, root) = figure(8.4, 3.2, 2)
    axes = (1.0, 0.45, 0.3)
    around = np.linspace(0, 2 * np.pi, 300)
    plane.plot(axes[0] * np.cos(around), axes[1] * np.sin(around), color=GREY)
    targets = [
        (0.9, 0.7),
        (-1.2, 0.35),
        (0.35, 0.12),
        (-0.3, -0.05),
        (0.0, -0.2),
        (1.25, -0.3),
        (-0.6, -0.75),
        (0.75, 0.0),
    ]
    points = np.array([(x, y, 1e-9) for x, y in targets])
    nearest = _sinew.nearest_on_ellipsoid(axes[:2] + (10.0,), np.ascontiguousarray(points))
    for (x, y), near in zip(targets, nearest, strict=True):
        plane.plot([x, near[0]], [y, near[1]], color=BLUE, linewidth=1)
        plane.plot(x, y, "o", color=BLUE, markersize=3)
    plain(plane)
    point = np.array([0.5, 0.2, 0.05])
    ratio = np.array(axes) / axes[2]
    gaps, numerators = ratio**2 - 1, ratio * point / axes[2]
    us = np.geomspace(0.05, 8, 300)
    values = [float((numerators**2 / (u + gaps) ** 2).sum()) - 1 for u in us]
    root.semilogx(us, values, color=BLUE)
    root.axhline(0, color=GREY, linewidth=0.8)
    low, high = max(numerators[2], *(numerators - gaps)), float(np.linalg.norm(numerators))
    root.axvspan(low, high, color=ORANGE, alpha=0.15)
    root.set(ylim=(-1, 2), xlabel="u", ylabel="Σ (nᵢ / (u + gᵢ))² − 1")
    root.text(low * 1.05, 1.7, "bracket", fontsize=8, color=ORANGE)
    save(drawing, "nearest")


def draw_influence():
    drawing, (weights, fading) = figure(8.4, 2.8, 2)
    tube = Tube(rings=161, around=12)
    for smooth, style in ((True, "-"), (False, ":")):
        influence = tube.influences("BLENDED" if smooth else "NEAREST")
        line = np.arange(161) * 12
        for tissue, colour in ((0, BLUE), (1, RED)):
            weights.plot(1000 * tube.points[line, 2], influence[line, tissue], style, color=colour)
    weights.set(xlabel="position along the skin, mm", ylabel="influence", xlim=(250, 550))
    weights.text(0.02, 0.42, "solid: blended\ndotted: nearest", fontsize=8, transform=weights.transAxes)
    distances = np.linspace(0, 0.04, 200)
    t = np.clip(1 - distances / 0.03, 0, 1)
    fading.plot(1000 * distances, t * t * (3 - 2 * t), color=BLUE)
    fading.set(xlabel="distance from the nearest tissue, mm", ylabel="nearness (falloff 30 mm)")
    save(drawing, "influence")
