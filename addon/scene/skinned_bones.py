# SPDX-License-Identifier: GPL-3.0-or-later
"""Which bones carry skin, and where that skin is, from a sample of the vertices of a rig's meshes."""

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from . import mesh_arrays, stored_settings

MOST_VERTICES = 6000  # read of each mesh: enough to see which bones carry skin, at 0.1 s for any mesh


@dataclass(frozen=True)
class SkinnedBones:
    """What the meshes of a rig show.

    weights: the sum of the weights of each bone that carries skin, in sampled vertices. points: (sampled vertices, 3)
    float64, armature space, at rest. strongest: the bone with the largest weight of each of them, "" without one.
    """

    weights: dict[str, float]
    points: np.ndarray
    strongest: tuple[str, ...] = ()

    def points_of(self, bones: set[str]) -> np.ndarray:
        """(points, 3): the points whose strongest bone is one of these."""
        return self.points[[name in bones for name in self.strongest]] if len(self.strongest) else self.points[:0]

    def carriers(self, rig) -> set[str]:
        """The bones that carry skin and all bones above them. Empty if no bone carries skin."""
        carrying = [rig.data.bones[name] for name in self.weights if name in rig.data.bones]
        return {bone.name for each in carrying for bone in (each, *each.parent_recursive)}


def skinned_bones(rig, skins: Iterable) -> SkinnedBones:
    """Reads the meshes of a rig. Vertices that are not finite numbers are skipped, and so are grown skins: they follow the
    muscles and so say nothing about where muscles belong.
    """
    weights: dict[str, float] = {}
    places, strongest = [np.empty((0, 3))], []
    has_inverse = abs(rig.matrix_world.determinant()) > 1e-12
    for skin in skins:
        mesh = skin.data
        if mesh.is_editmode or not mesh.vertices or not has_inverse or stored_settings.is_grown(skin):
            continue
        stride = 1 + len(mesh.vertices) // MOST_VERTICES
        to_armature = np.array(rig.matrix_world.inverted() @ skin.matrix_world)
        points = mesh_arrays.read_points(mesh)[::stride].astype(np.float64)
        places.append(points @ to_armature[:3, :3].T + to_armature[:3, 3])
        names = {group.index: group.name for group in skin.vertex_groups if group.name in rig.data.bones}
        for index in range(0, len(mesh.vertices), stride):
            best, most = "", 0.0
            for element in mesh.vertices[index].groups:
                if element.weight > 0.0 and element.group in names:
                    name = names[element.group]
                    weights[name] = weights.get(name, 0.0) + element.weight
                    best, most = (name, element.weight) if element.weight > most else (best, most)
            strongest.append(best)
    found = np.concatenate(places)
    finite = np.isfinite(found).all(axis=1)
    return SkinnedBones(weights, found[finite], tuple(np.array(strongest, object)[finite]) if strongest else ())
