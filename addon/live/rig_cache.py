# SPDX-License-Identifier: GPL-3.0-or-later
"""The cached rest pose and musculature of a rig, with the data they were made from, and the test whether they still fit."""

from dataclasses import dataclass

import _sinew
import numpy as np

from ..errors import SinewError
from ..scene import mixing, rig_pose, tissue_display, tissue_empty
from ..scene.character_index import CharacterIndex
from . import tissue_snapshot
from .edit_flags import EditScope


@dataclass
class RigState:
    """The rest pose and musculature of a rig, the data they were made from, and the arrays of the current frame.

    tissue_settings, tissue_rows, tissue_transforms: snapshots of the rig's tissues, then of its via points.
    solved: the indices, among the rig's tissues, of the tissues in the musculature. problems: the others, by name.
    character_index: the index of the file at the last full comparison. None: compare everything in the next frame.
    animated: the indices, among tissues and via points, of those that have keys or drivers.
    is_any_disabled: a tissue or via point is disabled in viewports. Blender does not report edits of these.
    influence: (solved,) float32, the setting of each tissue in the musculature.
    pose, tension, posed: of the current frame, as the core's `Musculature.pose` takes and returns them.
    bone_settings: as from `rig_pose.read_bone_settings`. None: read them again.
    """

    rest: rig_pose.RigRest
    tissue_settings: list[tuple]
    tissue_rows: np.ndarray
    tissue_transforms: np.ndarray
    musculature: _sinew.Musculature | None
    solved: list[int]
    problems: dict[str, str]
    character_index: CharacterIndex | None
    animated: list[int]
    is_any_disabled: bool
    display: tissue_display.TissueDisplay
    pose: np.ndarray
    influence: np.ndarray
    tension: np.ndarray
    posed: np.ndarray
    bone_settings: dict[str, np.ndarray] | None

    def has_rest_of(self, rig) -> bool:
        """Whether the rig still has this rest pose, bone for bone."""
        return rig_pose.signature(rig) == self.rest.signature and np.array_equal(
            rig_pose.rest_matrices(rig), self.rest.bone_rest
        )

    def still_fits(self, rig, tissues: list, edited: EditScope) -> bool:
        """Whether the state fits its rig, if only armatures and transforms were edited."""
        if EditScope.ARMATURES in edited and not self.has_rest_of(rig):
            return False
        if self.animated:
            if self.animated[-1] >= len(tissues):  # an animated via point
                return False
            settings = tissue_snapshot.settings_of([tissues[index] for index in self.animated])
            if settings != [self.tissue_settings[index] for index in self.animated]:
                return False
        if not self.animated and not self.is_any_disabled and EditScope.TRANSFORMS not in edited:
            return True
        return np.array_equal(tissue_snapshot.transforms_of(self.tissue_rows), self.tissue_transforms)


def read_musculature(rig, rest: rig_pose.RigRest, tissues: list, vias: list):
    """The musculature of a rig, as (musculature or None, indices of its tissues, problems of all other tissues by name)."""
    shapes, problems = {}, {}
    vias_by_muscle = tissue_empty.vias_by_muscle(vias)
    left_out = mixing.left_out(tissues)
    for index, empty in enumerate(tissues):
        if index in left_out:
            continue
        try:
            shapes[index] = tissue_empty.read(empty, rig, vias_by_muscle.get(empty.name_full, []))
        except SinewError as error:
            problems[empty.name] = str(error)
    spheres = {shape.name for shape in shapes.values() if shape.kind == "SPHERE"}
    core_tissues, solved = [], []
    for index, shape in shapes.items():
        try:
            core_tissues.append(_tissue(shape, rest, spheres, mixing.influence_of(tissues[index])))
            solved.append(index)
        except (SinewError, _sinew.SinewError) as error:
            problems[shape.name] = str(error)
    return (_sinew.Musculature(rest.skeleton, core_tissues) if core_tissues else None), solved, problems


def _tissue(shape: tissue_empty.TissueShape, rest: rig_pose.RigRest, spheres: set[str], influence: float) -> _sinew.Tissue:
    unsolved = [name for name in shape.wraps if name not in spheres]
    if unsolved:
        raise SinewError(
            f"{shape.name}: wraps around {unsolved[0]}, which has a problem itself; fix that, or wrap another sphere"
        )
    return _sinew.Tissue(
        shape.name,
        shape.kind,
        rest.index_of_bone[shape.origin_bone],
        rest.index_of_bone[shape.insertion_bone],
        tuple(shape.centre),
        tuple(shape.rotation),
        tuple(shape.semi_axes),
        shape.origin_tendon,
        shape.insertion_tendon,
        influence * shape.volume_keeping,
        via_points=[(rest.index_of_bone[bone], tuple(point)) for bone, point in shape.via_points],
        wraps=shape.wraps,
    )
