# SPDX-License-Identifier: GPL-3.0-or-later
"""The cached rest pose and musculature of a rig, with the data they were made from, and the test whether they still fit."""

from dataclasses import dataclass

import _sinew
import numpy as np

from ..errors import SinewError
from ..scene import animated_value, mixing, rig_pose, tissue_display, tissue_empty
from ..scene.character_index import CharacterIndex
from . import tissue_snapshot
from .edit_flags import EditScope

_OF_BONE = "].sinew"  # in the data path of a setting of a bone


@dataclass
class Expected:
    """What `live/forecast` wrote before an evaluation, for the pose and tension that it expected.

    pose, tension: as in `RigState`. skins: the binds whose corrections the meshes have, by the identifiers of the skins.
    is_right: whether the evaluation had this pose and tension, or None before it is known.
    """

    pose: np.ndarray
    tension: np.ndarray
    skins: dict[int, object]
    is_right: bool | None = None

    def compare(self, state: "RigState"):
        """Compares the pose and tension of an evaluation that has ended."""
        self.is_right = np.array_equal(self.pose, state.pose) and np.array_equal(self.tension, state.tension)


@dataclass
class RigState:
    """The rest pose and musculature of a rig, the data they were made from, and the arrays of the current frame.

    rig_name: for the texts of problems, which name it.
    tissue_settings, tissue_rows, tissue_transforms: snapshots of the rig's tissues, then of its via points.
    solved: the indices, among the rig's tissues, of the tissues in the musculature. unusable: why others are not in it, by
    name. problems: these, and what else is wrong with a tissue.
    character_index: the index of the file at the last full comparison. None: compare everything in the next frame.
    animated: the indices, among tissues and via points, of those that have keys or drivers.
    animated_shapes: those of them with keys or drivers for more than the tension. has_keyed_bones: settings of bones are
    keyed or driven. animation_sources: as from `animated_value.sources_of` of the rig.
    is_any_disabled: a tissue or via point is disabled in viewports. Blender does not report edits of these.
    influence: (solved,) float32, the setting of each tissue in the musculature.
    pose, tension, posed: of the current frame, as the core's `Musculature.pose` takes and returns them.
    bone_settings: as from `rig_pose.read_bone_settings`. are_bones_dirty: read them again.
    expected: what was written before the evaluation that has just ended, or None.
    """

    rig_name: str
    rest: rig_pose.RigRest
    tissue_settings: list[tuple]
    tissue_rows: np.ndarray
    tissue_transforms: np.ndarray
    musculature: _sinew.Musculature | None
    solved: list[int]
    unusable: dict[str, str]
    problems: dict[str, str]
    character_index: CharacterIndex | None
    animated: list[int]
    animated_shapes: list[int]
    animation_sources: tuple
    has_keyed_bones: bool
    is_any_disabled: bool
    display: tissue_display.TissueDisplay
    pose: np.ndarray
    influence: np.ndarray
    tension: np.ndarray
    posed: np.ndarray
    bone_settings: dict[str, np.ndarray] | None
    are_bones_dirty: bool = False
    expected: Expected | None = None

    def has_rest_of(self, rig) -> bool:
        """Whether the rig still has this rest pose, bone for bone."""
        return rig_pose.signature(rig) == self.rest.signature and np.array_equal(
            rig_pose.rest_matrices(rig), self.rest.bone_rest
        )

    def still_fits(
        self, rig, tissues: list, vias: list, edited: EditScope, depsgraph, read: tissue_snapshot.ObjectTransforms
    ) -> bool:
        """Whether the state fits its rig in an evaluation, if only armatures and transforms were edited."""
        if EditScope.ARMATURES in edited and not self.has_rest_of(rig):
            return False
        if self.animation_sources != animated_value.sources_of(rig):
            return False
        empties = tissues + vias
        if self.is_any_disabled or EditScope.TRANSFORMS in edited:
            transforms = tissue_snapshot.transforms_of(empties, self.tissue_rows, depsgraph, read)
            if not np.array_equal(transforms, self.tissue_transforms):
                return False
        return all(self._fits_animated(empties[index], index, len(tissues), depsgraph) for index in self.animated_shapes)

    def _fits_animated(self, empty, index: int, tissue_count: int, depsgraph) -> bool:
        is_via = index >= tissue_count  # its settings can't be animated
        return (
            is_via or [self.tissue_settings[index]] == tissue_snapshot.settings_of([empty], depsgraph)
        ) and np.array_equal(tissue_snapshot.transform_of(empty, depsgraph), self.tissue_transforms[index])

    def set_tension(self, index: int, values):
        """Sets the tension of a tissue of the musculature: that of an Empty, limited to 0..1, times its influence."""
        self.tension[index] = self.influence[index] * min(max(values.sinew.tissue.tension, 0.0), 1.0)

    def update_bone_settings(self, rig, depsgraph):
        """Reads the settings of bones again, if one was edited or if some are keyed."""
        if self.bone_settings is not None and not (self.has_keyed_bones or self.are_bones_dirty):
            return
        self.are_bones_dirty = False
        before = self.bone_settings
        self.bone_settings = rig_pose.read_bone_settings(animated_value.values_of(rig, depsgraph), self.rest)
        if before is not None and same_arrays(before, self.bone_settings):
            self.bone_settings = before  # binds that were made with it still fit


def same_arrays(before: dict[str, np.ndarray], now: dict[str, np.ndarray]) -> bool:
    """Whether two dictionaries hold equal arrays."""
    return before is now or (before.keys() == now.keys() and all(np.array_equal(before[name], now[name]) for name in before))


def has_keyed_bones(rig) -> bool:
    """Whether settings of a rig's bones are keyed or driven."""
    return any(_OF_BONE in path for path in animated_value.paths_of(rig))


def unevaluated(empties: list, animated: list[int], depsgraph) -> dict[str, str]:
    """The Empties whose drivers and NLA strips have no effect, because Blender does not evaluate them, each with the reason.

    animated: as in `RigState`.
    """
    problems = {}
    for empty in (empties[index] for index in animated):
        if not animated_value.has_drivers_or_strips(empty) or empty.sinew.tissue.disabled_by_layer:
            continue
        if not animated_value.is_evaluated(empty.evaluated_get(depsgraph), depsgraph):
            problems[empty.name] = (
                f"{empty.name}: its drivers and NLA strips have no effect, because it is disabled or in an excluded "
                "collection. Enable it, or hide it with H"
            )
        elif empty.hide_render or any(collection.hide_render for collection in empty.users_collection):
            problems[empty.name] = (
                f"{empty.name}: its drivers and NLA strips have no effect in renders, because it or its collection is "
                "disabled in renders. Enable it; Empties are not rendered"
            )
    return problems


def read_musculature(rig, rest: rig_pose.RigRest, tissues: list, vias: list, depsgraph):
    """The musculature of a rig in an evaluation.

    Returns it, or None if it has no tissue, the indices of its tissues, and the problems of all other tissues by name.
    """
    shapes, problems = {}, {}
    vias_by_muscle = tissue_empty.vias_by_muscle(vias)
    left_out = mixing.left_out(tissues)
    for index, empty in enumerate(tissues):
        if index in left_out:
            continue
        try:
            shapes[index] = tissue_empty.read(empty, rig, vias_by_muscle.get(empty.name_full, []), depsgraph)
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
