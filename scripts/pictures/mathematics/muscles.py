"""The figures of docs/mathematics/muscles.md and paths.md."""

import _sinew
import numpy as np
from matplotlib.patches import Circle

from pictures.mathematics.bodies import arm, column_major, links_of, translation
from pictures.mathematics.canvas import BLUE, GREEN, GREY, ORANGE, RED, figure, plain, save


def draw_belly():
    drawing, (widths, shapes) = figure(8.4, 3.2, 2, width_ratios=(1.1, 1.0))
    lengths = np.linspace(0.02, 1.7, 240)
    for keeping, colour in ((0.0, GREY), (0.5, GREEN), (1.0, BLUE), (1.5, ORANGE)):
        ratios = np.array([straight_belly(length, keeping) for length in lengths])
        widths.plot(lengths, ratios[:, 0], color=colour, label=f"p = {keeping:g}")
        if keeping == 1.0:
            widths.plot(lengths, ratios[:, 2], color=BLUE, linestyle=":", label="stretch, with its floor")
    widths.set(xlabel="(path length − tendons) / rest belly length", ylabel="posed / rest", ylim=(0, 3.2))
    widths.legend(frameon=False, fontsize=8)
    around = np.linspace(0, 2 * np.pi, 200)
    for row, (length, tension, label) in enumerate(
        ((1.4, 0.0, "k = 1.4"), (1.0, 0.0, "k = 1"), (0.6, 0.0, "k = 0.6"), (1.0, 1.0, "k = 1, tension 1"))
    ):
        x, _, z = straight_belly(length, 1.0, tension)
        shapes.plot(0.5 * z * np.cos(around), 0.15 * x * np.sin(around) - 0.55 * row, color=BLUE)
        for side in (-1, 1):
            shapes.plot([side * 0.5 * z, side * (0.5 * length + 0.12)], [-0.55 * row] * 2, color=GREY, linewidth=1)
        shapes.text(0.95, -0.55 * row, label, va="center", fontsize=8)
    plain(shapes)
    shapes.set_xlim(-0.9, 1.7)
    save(drawing, "belly")


def straight_belly(length: float, keeping: float, tension: float = 0.0) -> np.ndarray:
    """(3,): posed semi-axes divided by rest semi-axes, of a belly of rest length 1 without tendons.

    length: the length of the posed muscle path.
    """
    rest = column_major([np.eye(4), translation(0, 0, 1)])
    skeleton = _sinew.Skeleton(["a", "b"], np.array([-1, 0], np.int32), rest)
    shape = _sinew.Tissue("m", "MUSCLE", 0, 1, (0, 0, 0.5), (1, 0, 0, 0), (0.15, 0.15, 0.5), 0, 0, keeping)
    out = np.empty((1, 4, 4), np.float32)
    pose = column_major([np.eye(4), translation(0, 0, length)])
    _sinew.Musculature(skeleton, [shape]).pose(pose, np.array([tension], np.float32), out)
    return np.linalg.norm(out[0, :3, :3], axis=1) / (0.15, 0.15, 0.5)


def draw_chain():
    drawing, axis = figure(6.4, 2.2)
    around = np.linspace(0, 2 * np.pi, 200)
    axis.plot(np.cos(around), 0.28 * np.sin(around), color=GREY, linewidth=2)
    for (centre, length), width in zip(links_of(), [link_width(*link) for link in links_of()], strict=True):
        axis.fill(centre + length * np.cos(around), 0.28 * width * np.sin(around), color=BLUE, alpha=0.18)
        axis.plot(centre + length * np.cos(around), 0.28 * width * np.sin(around), color=BLUE, linewidth=1)
    plain(axis)
    along = np.linspace(-0.999, 0.999, 4001)
    inside = [np.maximum(1 - ((along - centre) / length) ** 2, 0) for centre, length in links_of()]
    widths = [link_width(*link) * np.sqrt(part) for link, part in zip(links_of(), inside, strict=True)]
    ratio = np.max(widths, axis=0) / np.sqrt(1 - along**2)
    print(f"  least width over the middle 0.9: {ratio[abs(along) < 0.9].min():.3f}; 0.9 over {(ratio >= 0.9).mean():.3f}")
    save(drawing, "chain")


def link_width(centre: float, length: float) -> float:
    total = 1 + length**2 - centre**2
    return np.sqrt(0.5 * (total + np.sqrt(total**2 - 4 * length**2)))


def draw_path():
    drawing, axes = figure(8.4, 3.0, 3)
    for axis, degrees in zip(axes, (20, 70, 130), strict=True):
        musculature, pose = arm(degrees)
        points, offsets = musculature.path_points(pose)
        matrices = np.empty((musculature.ellipsoid_count, 4, 4), np.float32)
        musculature.pose_ellipsoids(pose, np.zeros(2, np.float32), matrices)
        elbow, hand = np.array([0.3, 0.0]), 0.3 + 0.26 * np.exp(1j * np.radians(degrees))
        axis.plot([0, elbow[0], hand.real], [0, elbow[1], hand.imag], color=GREY, linewidth=3, solid_capstyle="round")
        axis.add_patch(Circle(elbow, 0.04, fill=False, color=ORANGE))
        around = np.linspace(0, 2 * np.pi, 90)
        for matrix in matrices[1:]:
            m = matrix.T
            outline = m[:3, :3] @ np.array([0 * around, np.cos(around), np.sin(around)]) + m[:3, 3:]
            axis.fill(outline[1], outline[2], color=RED, alpha=0.22)
        path = points[offsets[1] : offsets[2]]
        axis.plot(path[:, 1], path[:, 2], color=RED, linewidth=1.4)
        axis.set_title(f"{degrees}°", fontsize=9)
        axis.set(xlim=(-0.05, 0.6), ylim=(-0.16, 0.32))
        plain(axis)
    save(drawing, "path")
