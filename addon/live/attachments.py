# SPDX-License-Identifier: GPL-3.0-or-later
"""The attachments of a rig's muscles in the pose of the last frame, and what is between them and the bellies."""

import weakref
from dataclasses import dataclass

import numpy as np

from ..display import tendons
from ..scene import bone_geometry, characters, tissue_empty
from .rig_cache import RigState

# attachments by rig, valid as long as the session keeps the rig's state
_attached: dict[int, "Attachments"] = {}


@dataclass(frozen=True)
class Attachments:
    """Attachments of the muscles of a rig.

    origins, insertions: (muscles, 4) float32, homogeneous, in the space of their bones.
    origin_bones, insertion_bones: (muscles,) indices of these bones in the pose.
    tendons_m: (muscles, 2) float32, the lengths of the tendons at the origin and at the insertion.
    rows: (muscles,) indices of the muscles in the posed tissues.
    """

    state: weakref.ref
    origins: np.ndarray
    origin_bones: np.ndarray
    insertions: np.ndarray
    insertion_bones: np.ndarray
    tendons_m: np.ndarray
    rows: np.ndarray

    def posed(self, pose: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """(origins, insertions), each (muscles, 3) float32, in armature space. pose: as in the core's `Musculature.pose`."""
        # the matrices are column-major, so a row vector is multiplied from the left
        return (
            np.einsum("pi,pij->pj", self.origins, pose[self.origin_bones])[:, :3],
            np.einsum("pi,pij->pj", self.insertions, pose[self.insertion_bones])[:, :3],
        )


def of(rig, state: RigState) -> Attachments:
    """The attachments of the muscles of a rig."""
    attached = _attached.get(rig.session_uid)
    if attached is None or attached.state() is not state:
        attached = _attached[rig.session_uid] = _read(rig, state)
    return attached


def forget():
    """Drops the attachments of all rigs."""
    _attached.clear()


def lines_of(rig, state: RigState) -> np.ndarray:
    """(points, 3) float32: the two ends of each line, in armature space and in the pose of the last frame.

    A straight muscle has two lines, its tendons. A curved muscle has the lines of its whole path.
    """
    attached = of(rig, state)
    belly = state.posed[attached.rows]
    centre, half = belly[:, 3, :3], belly[:, 2, :3]
    origins, insertions = attached.posed(state.pose)
    ends = np.stack((origins, centre - half, centre + half, insertions), axis=1)
    points, offsets = state.musculature.path_points(state.pose)
    is_straight = np.diff(offsets)[attached.rows] <= 2
    paths = [np.repeat(points[offsets[row] : offsets[row + 1]], 2, axis=0)[1:-1] for row in attached.rows[~is_straight]]
    return np.concatenate((ends[is_straight].reshape(-1, 3), *paths)).astype(np.float32)


def tendons_of(rig, state: RigState) -> np.ndarray:
    """(tubes, 4, 4) float32, column-major: the tendons of all muscles, as in `display.tendons`. `state.posed` is current."""
    attached = of(rig, state)
    points, offsets = state.musculature.path_points(state.pose)
    counts = np.diff(offsets)
    is_straight = counts[attached.rows] <= 2
    bellies = state.posed[attached.rows]
    origins, insertions = attached.posed(state.pose)
    tubes = [
        tendons.straight(bellies[is_straight], origins[is_straight], -1.0),
        tendons.straight(bellies[is_straight], insertions[is_straight], 1.0),
    ]
    if not is_straight.all():
        is_curved_path = np.zeros(len(counts), bool)
        is_curved_path[attached.rows[~is_straight]] = True
        tubes.append(
            tendons.curved(
                points[np.repeat(is_curved_path, counts)],
                np.concatenate(([0], np.cumsum(counts[is_curved_path]))),
                bellies[~is_straight],
                attached.tendons_m[~is_straight],
            )
        )
    return np.concatenate(tubes)


def _read(rig, state: RigState) -> Attachments:
    tissues = characters.tissues_of(rig)
    rows: list[int] = []
    tendons_m: list[tuple[float, float]] = []
    origins: list[tuple] = []
    insertions: list[tuple] = []
    for row, tissue in enumerate(state.solved):
        shape = tissue_empty.read(tissues[tissue], rig, [])  # via points do not move attachments
        if shape.kind != "MUSCLE":
            continue
        rows.append(row)
        tendons_m.append((shape.origin_tendon, shape.insertion_tendon))
        for end, bone, point in (
            (origins, shape.origin_bone, shape.origin),
            (insertions, shape.insertion_bone, shape.insertion),
        ):
            end.append((state.rest.index_of_bone[bone], bone_geometry.in_bone(rig, bone, point)))
    bones = [np.array([bone for bone, _ in end], np.intp) for end in (origins, insertions)]
    points = [np.array([(*point, 1.0) for _, point in end], np.float32).reshape(-1, 4) for end in (origins, insertions)]
    return Attachments(
        weakref.ref(state),
        *(points[0], bones[0], points[1], bones[1]),
        np.array(tendons_m, np.float32).reshape(-1, 2),
        np.array(rows, np.intp),
    )
