"""The figures of docs/mathematics, drawn from the functions of the core; started by figure_mathematics.py.

Each function named draw_X writes docs/mathematics/X.svg. Numbers that the pages quote from a figure are printed.
"""

import sys
from pathlib import Path

import matplotlib

matplotlib.use("Agg")

import _sinew
import numpy as np
from figure_bodies import Tube, arm, column_major, links_of, moved, section
from matplotlib import pyplot
from matplotlib.patches import Circle

FOLDER = Path(__file__).resolve().parent.parent / "docs" / "mathematics"
BLUE, ORANGE, GREEN, RED, GREY = "#2b6cb0", "#dd6b20", "#2f855a", "#c53030", "#718096"


def figure(width: float, height: float, columns: int = 1, **options):
    """A figure and its axes, one or a list."""
    drawing, axes = pyplot.subplots(1, columns, figsize=(width, height), layout="constrained", **options)
    for axis in np.atleast_1d(axes):
        axis.spines[["top", "right"]].set_visible(False)
    return drawing, axes


def save(drawing, name: str):
    """Writes a figure; the same bytes each time."""
    path = FOLDER / f"{name}.svg"
    drawing.savefig(path, metadata={"Date": None})
    pyplot.close(drawing)
    text = path.read_text(encoding="utf-8")
    path.write_text("\n".join(line.rstrip() for line in text.splitlines()) + "\n", encoding="utf-8")
    print(f"{path.name}: {path.stat().st_size / 1024:.0f} kB")


def plain(axis):
    axis.set_aspect("equal")
    axis.set_axis_off()


def draw_belly():
    drawing, (widths, shapes) = figure(8.4, 3.2, 2, width_ratios=(1.1, 1.0))
    lengths = np.linspace(0.02, 1.7, 240)
    for keeping, colour in ((0.0, GREY), (0.5, GREEN), (1.0, BLUE), (1.5, ORANGE)):
        found = np.array([straight_belly(length, keeping) for length in lengths])
        widths.plot(lengths, found[:, 0], color=colour, label=f"p = {keeping:g}")
        if keeping == 1.0:
            widths.plot(lengths, found[:, 2], color=BLUE, linestyle=":", label="stretch, with its floor")
    widths.set(xlabel="(path length − tendons) / rest belly length", ylabel="posed / rest", ylim=(0, 3.2))
    widths.legend(frameon=False, fontsize=8)
    around = np.linspace(0, 2 * np.pi, 200)
    for place, (length, tension, label) in enumerate(
        ((1.4, 0.0, "k = 1.4"), (1.0, 0.0, "k = 1"), (0.6, 0.0, "k = 0.6"), (1.0, 1.0, "k = 1, tension 1"))
    ):
        x, _, z = straight_belly(length, 1.0, tension)
        shapes.plot(0.5 * z * np.cos(around), 0.15 * x * np.sin(around) - 0.55 * place, color=BLUE)
        for side in (-1, 1):
            shapes.plot([side * 0.5 * z, side * (0.5 * length + 0.12)], [-0.55 * place] * 2, color=GREY, linewidth=1)
        shapes.text(0.95, -0.55 * place, label, va="center", fontsize=8)
    plain(shapes)
    shapes.set_xlim(-0.9, 1.7)
    save(drawing, "belly")


def straight_belly(length: float, keeping: float, tension: float = 0.0) -> np.ndarray:
    """Posed over rest semi-axes of a belly of rest length 1 and no tendons whose path has this length."""
    rest = column_major([np.eye(4), moved(0, 0, 1)])
    skeleton = _sinew.Skeleton(["a", "b"], np.array([-1, 0], np.int32), rest)
    shape = _sinew.Tissue("m", "MUSCLE", 0, 1, (0, 0, 0.5), (1, 0, 0, 0), (0.15, 0.15, 0.5), 0, 0, keeping)
    out = np.empty((1, 4, 4), np.float32)
    pose = column_major([np.eye(4), moved(0, 0, length)])
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
    widths = [link_width(*link) * np.sqrt(own) for link, own in zip(links_of(), inside, strict=True)]
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


def draw_nearest():
    drawing, (plane, root) = figure(8.4, 3.2, 2)
    axes = (1.0, 0.45, 0.3)
    around = np.linspace(0, 2 * np.pi, 300)
    plane.plot(axes[0] * np.cos(around), axes[1] * np.sin(around), color=GREY)
    places = [(0.9, 0.7), (-1.2, 0.35), (0.35, 0.12), (-0.3, -0.05), (0.0, -0.2), (1.25, -0.3), (-0.6, -0.75), (0.75, 0.0)]
    points = np.array([(x, y, 1e-9) for x, y in places])
    found = _sinew.nearest_on_ellipsoid(axes[:2] + (10.0,), np.ascontiguousarray(points))
    for (x, y), near in zip(places, found, strict=True):
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
        found = tube.influences("BLENDED" if smooth else "NEAREST")
        line = np.arange(161) * 12
        for tissue, colour in ((0, BLUE), (1, RED)):
            weights.plot(1000 * tube.points[line, 2], found[line, tissue], style, color=colour)
    weights.set(xlabel="position along the skin, mm", ylabel="influence", xlim=(250, 550))
    weights.text(0.02, 0.42, "solid: blended\ndotted: nearest", fontsize=8, transform=weights.transAxes)
    distances = np.linspace(0, 0.04, 200)
    t = np.clip(1 - distances / 0.03, 0, 1)
    fading.plot(1000 * distances, t * t * (3 - 2 * t), color=BLUE)
    fading.set(xlabel="distance from the nearest tissue, mm", ylabel="nearness (falloff 30 mm)")
    save(drawing, "influence")


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


def deformers():
    return (
        ("linear blend skinning", GREY, {"elastic": False}),
        ("dual quaternions", ORANGE, {"elastic": False, "skinning": "PRESERVE_VOLUME"}),
        ("Sinew, 10 iterations", BLUE, {}),
    )


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
        found = [tube.quality(tube.deformed(skin, degrees)) for degrees in angles]
        axis.plot(angles, [own.union for own in found], color=colour, label=f"{label}")
        axis.plot(angles, [own.volume for own in found], color=colour, linestyle=":")
    without = tube.skin(volume=np.zeros(2, np.float32))
    found = [tube.quality(tube.deformed(without, degrees)).union for degrees in angles]
    axis.plot(angles, found, color=GREEN, label="Sinew, Keep Volume 0")
    axis.set(xlabel="bend, degrees", ylabel="volume of the joint region / rest")
    axis.legend(frameon=False, fontsize=8, title="solid: occupied, dotted: signed", title_fontsize=8)
    save(drawing, "volume")


def draw_convergence():
    drawing, axis = figure(5.2, 3.0)
    tube = Tube()
    counts = [1, 2, 3, 4, 5, 7, 10, 14, 20, 28, 40, 60]
    for degrees, colour in ((60, GREEN), (100, BLUE), (140, ORANGE)):
        end = tube.deformed(tube.skin(iterations=400), degrees)
        errors = []
        for count in counts:
            away = tube.deformed(tube.skin(iterations=count), degrees) - end
            errors.append(1000 * float(np.sqrt((away**2).sum(axis=1)).max()))
        axis.loglog(counts, errors, "o-", color=colour, markersize=3, label=f"bend {degrees}°")
        print(f"  {degrees} degrees: " + ", ".join(f"{n}: {e:.2f} mm" for n, e in zip(counts, errors, strict=True)))
        away = tube.deformed(tube.skin(iterations=10), degrees) - end
        across, along = np.abs((away * tube.normals(end)).sum(axis=1)), np.linalg.norm(away, axis=1)
        shares = f"{1000 * across.mean():.2f} mm on average along the normal, {1000 * along.mean():.2f} mm in all"
        print(f"  {degrees} degrees, 10 against 400 iterations: {shares}")
        for name, own in (("tube", tube), ("tube of half the spacing", Tube(rings=145, around=80))):
            for count in (10, 20, 60, 400):
                posed = own.deformed(own.skin(iterations=count), degrees)
                quality = own.quality(posed)
                volume, edge = f"{quality.union:.3f}", f"{quality.edge_p99:.2f}"
                print(f"  {name}, {degrees} degrees, {count} iterations: volume {volume}, edge stretch {edge}")
    axis.set(xlabel="iterations", ylabel="largest distance from 400 iterations, mm")
    axis.legend(frameon=False, fontsize=8)
    save(drawing, "convergence")


def draw_crease():
    drawing, axes = figure(8.4, 3.0, 3)
    tube = Tube()
    off, on = np.zeros(2, np.float32), np.ones(2, np.float32)
    cases = (("Crease 0, Skin Contact off", off, False), ("Crease 1, Skin Contact off", on, False), ("both on", on, True))
    for axis, (label, crease, contacts) in zip(axes, cases, strict=True):
        posed = tube.deformed(tube.skin(crease=crease, contacts=contacts), 150)
        for line in section(posed, tube.triangles):
            axis.plot(line[:, 0], line[:, 1], color=BLUE, linewidth=1.3)
        axis.set_title(label, fontsize=9)
        print(f"  {label}: {tube.quality(posed).new_hits} new self-intersections")
        plain(axis)
    save(drawing, "crease")


def draw_push():
    drawing, axis = figure(5.2, 2.8)
    depth = np.linspace(-0.02, 1.1, 300)
    t = np.clip((depth - 0.35) / 0.65, 0, 1)
    fading = 1 - t * t * (3 - 2 * t)
    axis.plot(depth, np.maximum(depth, 0) * 0.5, color=GREY, linestyle=":", label="half of the depth")
    axis.plot(depth, np.maximum(depth, 0) * 0.5 * fading, color=BLUE, label="displacement of one side")
    axis.set(xlabel="depth / reach of the cluster pair", ylabel="displacement / reach")
    axis.legend(frameon=False, fontsize=8)
    save(drawing, "push")


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


def draw_reach():
    drawing, axes = figure(8.4, 2.9, 3)
    goal, far = (0.0, 0.45, 0.55), (0.0, 1.1, 0.6)
    cases = (
        ("a goal within reach", goal, None),
        ("first two joints at eagerness 0.2", goal, np.array([0.2, 0.2, 1.0, 1.0])),
        ("a goal out of reach", far, None),
    )
    for axis, (label, target, multipliers) in zip(axes, cases, strict=True):
        count, length = 4, 0.25
        sockets = np.stack([np.eye(4)] + [moved(0, length, 0)] * (count - 1))
        limits = np.full((count, 3), 2.5)
        flat = np.array([1.0, 0.0, 0.0])
        ikchain = _sinew.Linkage(
            [f"{joint}" for joint in range(count)],
            np.arange(-1, count - 1, dtype=np.int32),
            np.ascontiguousarray(np.swapaxes(sockets, 1, 2)),
            ["XYZ"] * count,
            np.tile([0.15, 0.0, 0.0], (count, 1)),
            -limits * flat,
            limits * flat,
            multipliers=multipliers,
        )
        wish = _sinew.Goal(count - 1, "POSITION", target, point=(0, length, 0))
        found = _sinew.reach(ikchain, [wish])
        for angles, colour in ((ikchain.angles, GREY), (found.angles, BLUE)):
            heads = ikchain.heads(angles)
            turned = np.cumsum(angles[:, 0])[-1]
            tip = heads[-1] + length * np.array([0, np.cos(turned), np.sin(turned)])
            line = np.vstack([heads, tip])
            axis.plot(line[:, 1], line[:, 2], "o-", color=colour, markersize=4)
        axis.plot(target[1], target[2], "x", color=RED, markersize=8)
        axis.set_title(label, fontsize=9)
        axis.set(xlim=(-0.1, 1.2), ylim=(-0.1, 0.9))
        plain(axis)
        print(f"  {label}: miss {1000 * found.misses[0]:.3f} mm, {found.evaluations} evaluations")
    save(drawing, "reach")


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
    for place, (peak, colour) in enumerate(zip(at, (GREY, BLUE, GREEN, ORANGE), strict=True)):
        if peak < 0:
            tent = np.clip(values / peak, 0, 1)
        else:
            inner = at[place - 1] if place > 1 else 0.0
            tent = (values - inner) / (peak - inner)
            if place + 1 < len(at):
                tent = np.minimum(tent, (at[place + 1] - values) / (at[place + 1] - peak))
            tent = np.clip(tent, 0, 1)
        axis.plot(values, tent, color=colour, label=f"{peak:g}°")
    axis.set(xlabel="angle of the joint, degrees", ylabel="weight")
    axis.legend(frameon=False, fontsize=8, loc="center left", bbox_to_anchor=(1.0, 0.5), title="key at", title_fontsize=8)
    save(drawing, "tents")


def main() -> int:
    matplotlib.rcParams.update(
        {
            "svg.fonttype": "none",
            "svg.hashsalt": "sinew",
            "font.size": 9,
            "font.family": "sans-serif",
            "font.sans-serif": ["Helvetica", "Arial", "DejaVu Sans"],
            "path.simplify_threshold": 0.3,
        }
    )
    drawings = {name.removeprefix("draw_"): own for name, own in globals().items() if name.startswith("draw_")}
    unknown = set(sys.argv[1:]) - drawings.keys()
    if unknown:
        print(f"no figure {', '.join(sorted(unknown))}; there are {', '.join(drawings)}", file=sys.stderr)
        return 2
    for name, draw in drawings.items():
        if name in sys.argv[1:] or len(sys.argv) == 1:
            draw()
    return 0


if __name__ == "__main__":
    sys.exit(main())
