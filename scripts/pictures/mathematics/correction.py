"""The figure of docs/mathematics/correction.md."""

import numpy as np

from pictures.mathematics.canvas import BLUE, GREY, ORANGE, figure, save


def draw_damped():
    drawing, (flat, bound) = figure(8.4, 2.8, 2)
    s = np.geomspace(0.002, 1, 400)
    size = np.sqrt((2 + s**2) / 3)
    full = s / size**3
    damping = (0.125 * size * np.maximum(1 - full / 0.05, 0)) ** 2
    flat.loglog(s, 1 / s, color=GREY, linestyle=":", label="exact inverse")
    flat.loglog(s, s / (s**2 + damping), color=ORANGE, label="damped")
    unit = 1 / size
    raw = s / (s**2 + damping)
    flat.loglog(s, limited(raw / unit) * unit, color=BLUE, label="damped and bounded")
    flat.set(xlabel="s, for a map diag(1, 1, s)", ylabel="|offset| / |wanted|, along s")
    flat.legend(frameon=False, fontsize=8)
    raw = np.linspace(0, 24, 200)
    bound.plot(raw, raw, color=GREY, linestyle=":")
    bound.plot(raw, limited(raw), color=BLUE)
    bound.set(xlabel="lengthening before the bound", ylabel="after", ylim=(0, 10))
    save(drawing, "damped")


def limited(lengthening: np.ndarray) -> np.ndarray:
    over = np.maximum(lengthening - 4, 0) / 4
    return np.where(lengthening <= 4, lengthening, 4 + 4 * (1 - np.exp(-over)))
