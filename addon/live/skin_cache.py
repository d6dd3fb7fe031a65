# SPDX-License-Identifier: GPL-3.0-or-later
"""A bound mesh with what it was bound from, which tells whether the bind still fits; and how it is bound."""

from dataclasses import dataclass

import _sinew
import numpy as np

from ..errors import SinewError
from ..scene import armature_modifier, bone_weights, mesh_arrays, rig_pose
from .rig_cache import RigState

REACH_OF_RIG_SIZE = 0.03 / 1.73  # 3 cm on a man of 1.73 m (ALGORITHM 3)
SOFTNESS_OF_RIG_SIZE = 0.004 / 1.73
SAME_PLACE_OF_SIZE = 1e-5


@dataclass
class SkinState:
    """A bound mesh: what it was bound from, the bind, and the arrays of its current frame."""

    rest: rig_pose.RigRest
    musculature: _sinew.Musculature
    mesh_uid: int
    points: np.ndarray
    edge_count: int
    mesh_to_armature: np.ndarray
    settings: tuple
    weighing: tuple  # see weighing_of
    weights: bone_weights.BoneWeights
    bone_settings: dict[str, np.ndarray]
    painted: dict[str, np.ndarray]
    skin: _sinew.Skin
    correction: np.ndarray
    present: np.ndarray
    written: np.ndarray | None = None  # some of the correction that was written to the mesh last
    report: _sinew.FrameReport | None = None
    suspect: bool = False

    def fits(self, mesh, rig: RigState, mesh_to_armature: np.ndarray) -> bool:
        """Whether a bind fits a mesh, which was not edited since, in its place and on its rig of this frame."""
        return (
            not self.suspect
            and self.mesh_uid == mesh.session_uid
            and (len(self.points), self.edge_count) == (len(mesh.vertices), len(mesh.edges))
            and self.rest is rig.rest
            and self.musculature is rig.musculature
            and self.bone_settings is rig.bone_settings
            and _same_place(self.mesh_to_armature, mesh_to_armature, rig.rest.size)
        )

    def is_of_same_mesh(self, mesh, points, weighing: tuple, rest: rig_pose.RigRest, mesh_to_armature) -> bool:
        """Whether nothing changed of what the weights were read from, but for the weights themselves."""
        return (
            self.mesh_uid == mesh.session_uid
            and self.rest is rest
            and self.weighing == weighing
            and self.edge_count == len(mesh.edges)
            and np.array_equal(self.points, points)
            and _same_place(self.mesh_to_armature, mesh_to_armature, rest.size)
        )


def bind(skin, rig: RigState, points, edges, mesh_to_armature, weights, painted) -> _sinew.Skin:
    """The core's skin of a mesh, as its settings ask. Raises SinewError where there are no tissues, ValueError of the core."""
    if rig.musculature is None:
        if rig.problems:
            raise SinewError(f"{skin.name}: none of its armature's muscles can be used. {'; '.join(rig.problems.values())}")
        raise SinewError(f"{skin.name}: its armature has no muscles; add some (Add Preset, Add Tissue)")
    own = skin.sinew
    reach, softness = _lengths(own, rig.rest.size)
    return _sinew.Skin(
        rig.musculature,
        points,
        edges,
        mesh_to_armature,
        weights.offsets,
        weights.frames,
        weights.weights,
        skinning=armature_modifier.skinning_of(skin),
        anchoring=own.anchoring,
        # nothing else could carry a mesh without weights
        carry=own.carry if len(weights.frames) else "FULL",
        scale_fat=own.scale_fat,
        reach=reach,
        softness=softness,
        gain=own.gain,
        muscle_influence=_regional("muscle_influence", 1.0, rig, painted),
        elasticity=_elasticity(skin, rig, edges, painted) if own.elastic else None,
    )


def _regional(name: str, of_mesh: float, rig: RigState, painted) -> _sinew.Regional:
    return _sinew.Regional(of_mesh, rig.bone_settings.get(name), painted.get(name))


def _elasticity(skin, rig: RigState, edges, painted) -> _sinew.Elasticity:
    mesh, own = skin.data, skin.sinew
    return _sinew.Elasticity(
        mesh_arrays.read_struts(mesh, edges),
        mesh_arrays.read_triangles(mesh),
        rig.rest.segments,
        rig.rest.lengths,
        own.iterations,
        energy=own.energy,
        anchor_stiffness=_regional("anchor_stiffness", own.anchor_stiffness, rig, painted),
        edge_stiffness=_regional("edge_stiffness", own.edge_stiffness, rig, painted),
        rest_distance=_regional("rest_distance", own.rest_distance, rig, painted),
        relaxation=_regional("relaxation", 1.0, rig, painted),
        fat_sliding=_regional("fat_sliding", own.fat_sliding, rig, painted),
        volume=rig.bone_settings.get("keep_volume"),
        crease=rig.bone_settings.get("crease"),
        contact=rig.bone_settings.get("contact"),
        collides=own.collides,
        contacts=own.contacts,
    )


def bind_settings(skin, rig_size: float) -> tuple:
    """All of a mesh's settings that `bind` reads."""
    own = skin.sinew
    return (
        own.anchoring, own.carry, own.scale_fat, own.gain, own.elastic, own.iterations, own.energy, own.anchor_stiffness,
        own.edge_stiffness, own.rest_distance, own.fat_sliding, own.collides, own.contacts, _lengths(own, rig_size)
    )  # fmt: skip


def weighing_of(skin) -> tuple:
    """What decides which of a mesh's vertex groups weigh, and how."""
    return armature_modifier.modifier_state(skin), skin.vertex_groups.keys()


def _lengths(own, rig_size: float) -> tuple[float, float]:
    """Reach and softness, in armature space; both follow the size of the rig unless the person chose a reach."""
    return own.reach or REACH_OF_RIG_SIZE * rig_size, SOFTNESS_OF_RIG_SIZE * rig_size


def _same_place(kept: np.ndarray, now: np.ndarray, size: float) -> bool:
    if np.array_equal(kept, now):
        return True
    # transforms of a character far from the world's origin tremble by rounding; that is no new place
    tolerance = SAME_PLACE_OF_SIZE * np.array([1.0, 1.0, 1.0, max(size, 1e-3)])[:, None]
    return bool((np.abs(kept - now) <= tolerance * max(1.0, float(np.abs(kept[:3]).max()))).all())
