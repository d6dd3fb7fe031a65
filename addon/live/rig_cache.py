# SPDX-License-Identifier: GPL-3.0-or-later
"""A rig's rest pose and musculature with what they were made from, which tells whether they still fit."""

from dataclasses import dataclass

import _sinew
import numpy as np

from ..errors import SinewError
from ..scene import characters, rig_pose, tissue_display, tissue_empty
from . import tissue_snapshot
from .edit_flags import EditScope


@dataclass
class RigState:
    """A rig's rest pose and musculature, what they were made from, and the arrays of the current frame."""

    rest: rig_pose.RigRest
    tissue_settings: list[tuple]
    tissue_rows: np.ndarray
    tissue_transforms: np.ndarray
    musculature: _sinew.Musculature | None
    solved: list[int]  # places, among the rig's tissues, of those that the musculature has
    problems: dict[str, str]
    character_index: characters.CharacterIndex | None  # of the last look at all of the file; None: to be looked at again
    animated: list[int]  # places, among the rig's tissues and via points, of those that have keys or drivers
    is_any_disabled: bool  # in viewports, of tissues and via points: what is edited of these, Blender does not report
    shown: tissue_display.TissueDisplay
    pose: np.ndarray
    tension: np.ndarray
    posed: np.ndarray
    bone_settings: dict[str, np.ndarray] | None  # see rig_pose.read_bone_settings; None: to be read again

    def has_rest_of(self, rig) -> bool:
        """Whether the rig still has this rest pose, bone for bone."""
        return rig_pose.signature(rig) == self.rest.signature and np.array_equal(
            rig_pose.rest_matrices(rig), self.rest.bone_rest
        )

    def still_fits(self, rig, tissues: list, edited: EditScope) -> bool:
        """Whether it fits its rig, where nothing else than armatures and transforms was edited."""
        if EditScope.ARMATURES in edited and not self.has_rest_of(rig):
            return False
        if self.animated:
            if self.animated[-1] >= len(tissues):  # a via point
                return False
            settings = tissue_snapshot.settings_of([tissues[place] for place in self.animated])
            if settings != [self.tissue_settings[place] for place in self.animated]:
                return False
        if not self.animated and not self.is_any_disabled and EditScope.TRANSFORMS not in edited:
            return True
        return np.array_equal(tissue_snapshot.transforms_of(self.tissue_rows), self.tissue_transforms)


def read_musculature(rig, rest: rig_pose.RigRest, tissues: list, vias: list):
    """The musculature of all tissues that can be solved, their places, and for each other one what is wrong with it."""
    shapes, problems = {}, {}
    vias_by_muscle = tissue_empty.vias_by_muscle(vias)
    for place, empty in enumerate(tissues):
        try:
            shapes[place] = tissue_empty.read(empty, rig, vias_by_muscle.get(empty.name_full, []))
        except SinewError as error:
            problems[empty.name] = str(error)
    spheres = {shape.name for shape in shapes.values() if shape.kind == "SPHERE"}
    found, solved = [], []
    for place, shape in shapes.items():
        try:
            found.append(_tissue(shape, rest, spheres))
            solved.append(place)
        except (SinewError, _sinew.SinewError) as error:
            problems[shape.name] = str(error)
    return (_sinew.Musculature(rest.skeleton, found) if found else None), solved, problems


def _tissue(shape: tissue_empty.TissueShape, rest: rig_pose.RigRest, spheres: set[str]) -> _sinew.Tissue:
    unsolved = [name for name in shape.wraps if name not in spheres]
    if unsolved:
        raise SinewError(
            f"{shape.name}: goes round {unsolved[0]}, which has a problem of its own; mend that, or wrap another"
        )
    return _sinew.Tissue(
        shape.name,
        shape.kind,
        rest.frame_of_bone[shape.origin_bone],
        rest.frame_of_bone[shape.insertion_bone],
        tuple(shape.centre),
        tuple(shape.rotation),
        tuple(shape.semi_axes),
        shape.origin_tendon,
        shape.insertion_tendon,
        shape.volume_keeping,
        via_points=[(rest.frame_of_bone[bone], tuple(point)) for bone, point in shape.via_points],
        wraps=shape.wraps,
    )
