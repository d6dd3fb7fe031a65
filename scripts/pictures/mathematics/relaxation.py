"""The figures of docs/mathematics/relaxation.md and contact.md."""

import numpy as np

from pictures.mathematics.bodies import Tube, section
from pictures.mathematics.canvas import BLUE, GREEN, GREY, ORANGE, figure, plain, save


def draw_convergence():
    drawing, axis = figure(5.2, 3.0)
    tube = Tube()
    counts = [1, 2, 3, 4, 5, 7, 10, 14, 20, 28, 40, 60]
    for degrees, colour in ((60, GREEN), (100, BLUE), (140, ORANGE)):
        end = tube.deformed(tube.skin(iterations=400), degrees)
        errors = []
        for count in counts:
            error = tube.deformed(tube.skin(iterations=count), degrees) - end
            errors.append(1000 * float(np.sqrt((error**2).sum(axis=1)).max()))
        axis.loglog(counts, errors, "o-", color=colour, markersize=3, label=f"bend {degrees}°")
        print(f"  {degrees} degrees: " + ", ".join(f"{n}: {e:.2f} mm" for n, e in zip(counts, errors, strict=True)))
        error = tube.deformed(tube.skin(iterations=10), degrees) - end
        across, along = np.abs((error * tube.normals(end)).sum(axis=1)), np.linalg.norm(error, axis=1)
        shares = f"{1000 * across.mean():.2f} mm on average along the normal, {1000 * along.mean():.2f} mm in all"
        print(f"  {degrees} degrees, 10 against 400 iterations: {shares}")
        for name, body in (("tube", tube), ("tube of half the spacing", Tube(rings=145, around=80))):
            for count in (10, 20, 60, 400):
                posed = body.deformed(body.skin(iterations=count), degrees)
                quality = body.quality(posed)
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
        print(f"  {label}: {tube.quality(posed).new_intersections} new self-intersections")
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
