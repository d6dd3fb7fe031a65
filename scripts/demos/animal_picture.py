"""Renders the picture of an animal: its anatomy, the skin grown over it, and the skin in a pose, side by side."""

import tempfile
from dataclasses import dataclass
from pathlib import Path

import bpy
import numpy as np
from mathutils import Matrix

from demos.animals import ANIMALS
from demos.picture import (
    GAP,
    MUSCLE,
    Panel,
    add,
    join,
    light,
    material_of,
    matrix_of,
    mesh_of,
    render_panel,
    set_cycles,
    unit_ball,
)

COLOURS = {"MUSCLE": MUSCLE, "BONE": (0.80, 0.76, 0.64, 1.0), "STUFFING": (0.72, 0.52, 0.40, 1.0)}
ANATOMY, GROWN, POSED = range(3)
CAPTIONS = ("the anatomy", "the skin grown over it", "moving")
# size of a panel in pixels; middle, direction of the view, and m over the longer side
VIEWS = {
    "cat": ((620, 480), ((0.0, 0.02, 0.15), (1.0, -0.6, 0.25), 0.68)),
    "dog": ((620, 480), ((0.0, 0.0, 0.5), (1.0, -0.6, 0.25), 1.9)),
    "horse": ((620, 520), ((0.0, -0.2, 1.0), (1.0, -0.6, 0.25), 3.2)),
    "toad": ((620, 480), ((0.0, 0.0, 0.02), (0.7, -1.0, 0.5), 0.14)),
    "hand": ((560, 560), ((0.16, -0.06, -0.09), (0.9, -0.6, 0.25), 0.34)),
    "human": ((420, 800), ((0.0, 0.0, 0.98), (0.55, -1.0, 0.1), 2.3)),
}


@dataclass(frozen=True)
class Figure:
    """The figure in the picture: (V, 3) points at rest and posed; tissues as (kind, matrix from the unit sphere).

    materials: of the skin, or none. slots: (faces,) int32, the material of each face.
    """

    faces: list[tuple[int, ...]]
    rest: np.ndarray
    posed: np.ndarray
    anatomy: list[tuple[str, np.ndarray]]
    materials: list
    slots: np.ndarray


def render(target: Path, animal: str, figure: Figure) -> None:
    """Writes the picture."""
    scene = bpy.data.scenes.new("Picture")
    coat = material_of("coat", ANIMALS[animal].coat, 0.55)
    balls = {kind: unit_ball(material_of(kind.lower(), colour, 0.4)) for kind, colour in COLOURS.items()}
    for kind, ellipsoid in figure.anatomy:
        add(scene, balls[kind], matrix_of(ANATOMY) @ Matrix(ellipsoid.tolist()))
    for column, points in ((GROWN, figure.rest), (POSED, figure.posed)):
        mesh = mesh_of("figure", points, figure.faces, coat)
        for material in figure.materials[1:]:
            mesh.materials.append(material)
        mesh.polygons.foreach_set("material_index", figure.slots)
        add(scene, mesh, matrix_of(column))
    light(scene)
    set_cycles(scene)
    (width, height), view = VIEWS[animal]
    panels = [
        Panel(caption, column, column * (width + GAP), 0, width, height, *view) for column, caption in enumerate(CAPTIONS)
    ]
    with tempfile.TemporaryDirectory() as folder:
        rendered = [render_panel(scene, panel, Path(folder, f"{panel.figure}.png")) for panel in panels]
        join(panels, rendered, target)
