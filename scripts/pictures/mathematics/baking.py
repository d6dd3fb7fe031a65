"""The figures of docs/mathematics/baking.md."""

import _sinew
import numpy as np

from pictures.mathematics.bodies import Tube
from pictures.mathematics.canvas import BLUE, GREEN, GREY, ORANGE, figure, save


def draw_keep():
    drawing, axis = figure(6.4, 2.8)
    tube = Tube(rings=9, around=8)
    skin = tube.skin(elastic=False)
    frames = np.arange(0, 121, dtype=np.float64)
    value = 0.01 * (np.sin(frames / 12) ** 3 + 0.3 * np.maximum(0, np.sin(frames / 5 - 2)) ** 4)
    value[90:] = value[90]
    corrections = np.zeros((len(frames), len(tube.points), 3), np.float32)
    corrections[:, 0, 0] = value
    poses = np.repeat(tube.pose(0)[None], len(frames), axis=0)
    axis.plot(frames, 1000 * value, color=GREY, linewidth=3, alpha=0.5)
    for tolerance, colour in ((2.0, ORANGE), (0.5, BLUE)):
        kept = _sinew.KeptSamples(
            skin, poses, corrections, frames, np.full(len(frames), tolerance / 1000), np.ones(len(frames), bool)
        )
        shown = [0.0 if sample is None else 1000 * value[sample] for sample in kept.shown]
        axis.plot(
            frames[kept.places], shown, "o-", color=colour, markersize=4, linewidth=1, label=f"tolerance {tolerance} mm"
        )
        shapes = {sample for sample in kept.shown if sample is not None}
        print(f"  {tolerance} mm: {len(kept.places)} places, {len(shapes)} shapes, error {1000 * kept.errors.max():.3f} mm")
    axis.set(xlabel="frame", ylabel="correction, mm")
    axis.legend(frameon=False, fontsize=8)
    save(drawing, "keep")


def draw_tents():
    drawing, axis = figure(6.4, 2.2)
    values = np.linspace(-60, 150, 600)
    at = [-40.0, 35.0, 80.0, 120.0]
    for key, (peak, colour) in enumerate(zip(at, (GREY, BLUE, GREEN, ORANGE), strict=True)):
        if peak < 0:
            tent = np.clip(values / peak, 0, 1)
        else:
            inner = at[key - 1] if key > 1 else 0.0
            tent = (values - inner) / (peak - inner)
            if key + 1 < len(at):
                tent = np.minimum(tent, (at[key + 1] - values) / (at[key + 1] - peak))
            tent = np.clip(tent, 0, 1)
        axis.plot(values, tent, color=colour, label=f"{peak:g}°")
    axis.set(xlabel="angle of the joint, degrees", ylabel="weight")
    axis.legend(frameon=False, fontsize=8, loc="center left", bbox_to_anchor=(1.0, 0.5), title="key at", title_fontsize=8)
    save(drawing, "tents")
