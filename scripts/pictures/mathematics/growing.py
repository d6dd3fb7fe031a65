"""The figure of docs/mathematics/growing.md."""

import _sinew
import numpy as np

from pictures.mathematics.bodies import column_major, section
from pictures.mathematics.canvas import BLUE, GREY, figure, plain, save


def draw_grow():
    drawing, axes = figure(8.4, 2.4, 3)
    skeleton = _sinew.Skeleton(["a"], np.array([-1], np.int32), column_major([np.eye(4)]))
    turned = (np.cos(np.pi / 4), np.sin(np.pi / 4), 0.0, 0.0)
    shapes = [
        _sinew.Tissue("one", "STUFFING", 0, 0, (0, -0.13, 0), turned, (0.1, 0.1, 0.16)),
        _sinew.Tissue("two", "STUFFING", 0, 0, (0, 0.15, 0.02), turned, (0.08, 0.12, 0.16)),
    ]
    musculature = _sinew.Musculature(skeleton, shapes)
    around = np.linspace(0, 2 * np.pi, 200)
    for axis, smoothing in zip(axes, (0, 5, 40), strict=True):
        none = np.zeros(1, np.int32)
        skin = _sinew.GrownSkin(
            musculature, np.zeros(2, np.float32), np.ones(1, np.float32), none, resolution=83, smoothing=smoothing
        )
        quads = skin.quads
        triangles = np.concatenate((quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]))
        for line in section(skin.points, triangles):
            axis.plot(line[:, 0], line[:, 1], color=BLUE, linewidth=1.4)
        for y, z, wide, high in ((-0.13, 0, 0.16, 0.1), (0.15, 0.02, 0.16, 0.12)):
            axis.plot(y + wide * np.cos(around), z + high * np.sin(around), color=GREY, linewidth=0.7)
        axis.set_title(f"{smoothing} passes", fontsize=9)
        plain(axis)
        print(f"  {smoothing} passes: {len(skin)} vertices, protrusion {skin.protrusion / skin.voxel:.2f} voxels")
    save(drawing, "grow")
