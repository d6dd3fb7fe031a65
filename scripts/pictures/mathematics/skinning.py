"""The figures of docs/mathematics that compare Sinew with the deformers of Blender."""

import numpy as np

from pictures.mathematics.bodies import Tube, section
from pictures.mathematics.canvas import BLUE, GREEN, GREY, ORANGE, figure, plain, save


def deformers():
    return (
        ("linear blend skinning", GREY, {"elastic": False}),
        ("dual quaternions", ORANGE, {"elastic": False, "skinning": "PRESERVE_VOLUME"}),
        ("Sinew, 10 iterations", BLUE, {}),
    )


def draw_twist():
    drawing, axis = figure(5.2, 3.0)
    tube, angles = Tube(), np.arange(0, 181, 5)
    for label, colour, options in deformers():
        skin = tube.skin(**options)
        least = [tube.least_radius(tube.deformed(skin, degrees, "twist")) for degrees in angles]
        axis.plot(angles, least, color=colour, label=label)
        print(f"  twist of 120 degrees, {label}: least radius {least[24]:.3f} of rest")
    axis.set(xlabel="twist, degrees", ylabel="least radius / rest radius", ylim=(0, 1.1))
    axis.legend(frameon=False, fontsize=8)
    save(drawing, "twist")


def draw_bend():
    drawing, axes = figure(8.4, 3.0, 3)
    tube = Tube()
    for axis, (label, colour, options) in zip(axes, deformers(), strict=True):
        posed = tube.deformed(tube.skin(**options), 140)
        for line in section(posed, tube.triangles):
            axis.plot(line[:, 0], line[:, 1], color=colour, linewidth=1.3)
        quality = tube.quality(posed)
        axis.set_title(label, fontsize=9)
        print(f"  bend of 140 degrees, {label}: union {quality.union:.3f}, edge p99 {quality.edge_p99:.2f}")
        plain(axis)
    save(drawing, "bend")


def draw_volume():
    drawing, axis = figure(5.6, 3.2)
    tube, angles = Tube(), np.arange(0, 151, 10)
    for label, colour, options in deformers():
        skin = tube.skin(**options)
        qualities = [tube.quality(tube.deformed(skin, degrees)) for degrees in angles]
        axis.plot(angles, [quality.union for quality in qualities], color=colour, label=f"{label}")
        axis.plot(angles, [quality.volume for quality in qualities], color=colour, linestyle=":")
    without = tube.skin(volume=np.zeros(2, np.float32))
    unions = [tube.quality(tube.deformed(without, degrees)).union for degrees in angles]
    axis.plot(angles, unions, color=GREEN, label="Sinew, Keep Volume 0")
    axis.set(xlabel="bend, degrees", ylabel="volume of the joint region / rest")
    axis.legend(frameon=False, fontsize=8, title="solid: occupied, dotted: signed", title_fontsize=8)
    save(drawing, "volume")
