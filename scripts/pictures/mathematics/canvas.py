"""The axes, the colours and the file of a figure."""

import numpy as np
from build.layout import ROOT
from matplotlib import pyplot

FOLDER = ROOT / "docs/mathematics"
BLUE, ORANGE, GREEN, RED, GREY = "#2b6cb0", "#dd6b20", "#2f855a", "#c53030", "#718096"


def figure(width: float, height: float, columns: int = 1, **options):
    """A new figure, and its axes: one, or an array of them."""
    drawing, axes = pyplot.subplots(1, columns, figsize=(width, height), layout="constrained", **options)
    for axis in np.atleast_1d(axes):
        axis.spines[["top", "right"]].set_visible(False)
    return drawing, axes


def save(drawing, name: str):
    """Writes a figure to docs/mathematics. The same figure gives the same bytes."""
    path = FOLDER / f"{name}.svg"
    drawing.savefig(path, metadata={"Date": None})
    pyplot.close(drawing)
    text = path.read_text(encoding="utf-8")
    path.write_text("\n".join(line.rstrip() for line in text.splitlines()) + "\n", encoding="utf-8")
    print(f"{path.name}: {path.stat().st_size / 1024:.0f} kB")


def plain(axis):
    axis.set_aspect("equal")
    axis.set_axis_off()
