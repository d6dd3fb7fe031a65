# SPDX-License-Identifier: GPL-3.0-or-later
"""The cached bind of a mesh, with the data it was made from, and the test whether it still fits."""

from dataclasses import dataclass

import _sinew
import numpy as np

from ..errors import SinewError
from ..scene import armature_modifier, bone_weights, level_of_detail, mesh_arrays, rest_body, rig_pose
from ..scene.level_of_detail import Detail
from .rig_cache import RigState, same_arrays

# lengths for a human of 1.73 m, over the size of the rig (docs/mathematics/binding.md, Falloff)
FALLOFF_OF_RIG_SIZE = 0.03 / 1.73
SOFTNESS_OF_RIG_SIZE = 0.004 / 1.73
SAME_POSITION_OF_RIG_SIZE = 1e-5


@dataclass(frozen=True)
class SkinData:
    """What a bind reads from a mesh.

    points: (vertices, 3) float32, the rest body in mesh space. edges: (edges, 2) int32, those shown. mesh_to_armature:
    (4, 4) float32, column-major. painted: as from `painted_data.read`. shown: as from `rest_body.shown_vertices`. body: the
    bind of the mesh that a garment is worn over.
    """

    points: np.ndarray
    edges: np.ndarray
    mesh_to_armature: np.ndarray
    weights: bone_weights.BoneWeights
    painted: dict[str, np.ndarray]
    shown: np.ndarray | None
    body: "SkinState | None" = None


@dataclass
class SkinState:
    """A bound mesh: the data it was bound from, the bind, and the arrays of the current frame.

    topology: as from `mesh_arrays.topology_hash`. mesh_to_armature: (4, 4) float32, column-major, when the mesh was bound.
    settings: as from `bind_settings`. detail: as for `bind`. key_values: as from `rest_body.key_values`.
    weight_sources: as from `weight_sources_of`. shown: as from `rest_body.shown_vertices`. body: the bind that a garment
    follows.
    correction: of the current frame. mesh_correction: buffer for the correction that the mesh has. written_sample: a sample
    of the correction that was written last. follows: whether the Armature modifier was on when the correction was computed.
    is_dirty: Blender reported a change of the mesh, so weights and painted factors are read again in the next frame.
    """

    rest: rig_pose.RigRest
    musculature: _sinew.Musculature
    mesh_uid: int
    points: np.ndarray
    edge_count: int
    topology: bytes
    mesh_to_armature: np.ndarray
    settings: tuple
    detail: Detail
    key_values: tuple
    weight_sources: tuple
    weights: bone_weights.BoneWeights
    bone_settings: dict[str, np.ndarray]
    painted: dict[str, np.ndarray]
    shown: np.ndarray | None
    body: _sinew.Skin | None
    skin: _sinew.Skin
    correction: np.ndarray
    mesh_correction: np.ndarray
    written_sample: np.ndarray | None = None
    follows: bool = True
    report: _sinew.FrameReport | None = None
    is_dirty: bool = False

    def fits(self, skin, rig: RigState, mesh_to_armature: np.ndarray, detail: Detail) -> bool:
        """Whether the bind fits a mesh that was not edited since, at its position and on its rig of this frame."""
        mesh = skin.data
        return (
            not self.is_dirty
            and self.detail == detail
            and self.mesh_uid == mesh.session_uid
            and (len(self.points), self.edge_count) == (len(mesh.vertices), len(mesh.edges))
            and self.rest is rig.rest
            and self.musculature is rig.musculature
            and self.bone_settings is rig.bone_settings
            and is_same_transform(self.mesh_to_armature, mesh_to_armature, rig.rest.size)
            and self.key_values == rest_body.key_values(skin)  # a driver can change them without an edit of the mesh
        )

    def has_values_of(self, skin, values, detail: Detail, rig_size: float) -> bool:
        """Whether the settings of a mesh that can be animated are those of the bind. values, detail: as for `bind`."""
        return self.settings == bind_settings(values, detail, rig_size) and self.weight_sources == weight_sources_of(
            skin, values
        )

    def has_inputs(self, rig: RigState, settings: tuple, weights, painted, shown, body: _sinew.Skin | None) -> bool:
        """Whether the bind is that of these settings (`bind_settings`), and a rig's tissues. Others: as in `SkinState`."""
        return (
            self.musculature is rig.musculature
            and self.settings == settings
            and self.bone_settings is rig.bone_settings
            and self.body is body
            and self.weights == weights
            and same_arrays(self.painted, painted)
            and _same_masks(self.shown, shown)
        )

    def is_of_same_mesh(self, mesh, points, weight_sources: tuple, rest: rig_pose.RigRest, mesh_to_armature) -> bool:
        """Whether everything that the weights are read from is unchanged, except for the weights themselves."""
        return (
            self.mesh_uid == mesh.session_uid
            and self.rest is rest
            and self.weight_sources == weight_sources
            and self.edge_count == len(mesh.edges)
            and np.array_equal(self.points, points)
            and is_same_transform(self.mesh_to_armature, mesh_to_armature, rest.size)
        )


def bind(skin, values, detail: Detail, rig: RigState, data: SkinData) -> _sinew.Skin:
    """Binds a mesh with its settings. Raises SinewError if there are no tissues, and ValueError from the core.

    values: the object that has the settings of `skin` in this evaluation (`animated_value.values_of`). detail: how much
    of it the frames compute.
    """
    if rig.musculature is None:
        if rig.problems:
            raise SinewError(f"{skin.name}: none of its armature's muscles can be used. {'; '.join(rig.problems.values())}")
        raise SinewError(f"{skin.name}: its armature has no muscles; add some (Add Preset, Add Tissue)")
    settings, weights = values.sinew.skin, data.weights
    falloff, softness = _lengths(settings, rig.rest.size)
    return _sinew.Skin(
        rig.musculature,
        data.points,
        data.edges,
        data.mesh_to_armature,
        weights.offsets,
        weights.bones,
        weights.weights,
        skinning=armature_modifier.skinning_of(values),
        anchoring=settings.anchoring,
        # without weights, only the motion of the tissues can move the mesh
        motion_source=settings.motion_source if len(weights.bones) else "FULL",
        scale_fat=settings.scale_fat,
        falloff=falloff,
        softness=softness,
        gain=settings.muscle_influence,
        muscle_influence=_regional("muscle_influence", 1.0, rig, data.painted),
        elasticity=(
            _elasticity(skin.data, settings, detail.iterations, rig, data)
            if _is_elastic(settings, detail) and data.body is None
            else None
        ),
        preserved_fractions=weights.preserved_fractions,
        **_worn_over(skin, data),
    )


def _worn_over(skin, data: SkinData) -> dict:
    """The arguments of `_sinew.Skin` for a garment; none for other skins."""
    if data.body is None:
        return {}
    under = mesh_arrays.read_triangles(skin.sinew.skin.worn_over.data)
    return {
        "body": data.body.skin,
        "body_triangles": rest_body.shown_only(under, data.body.shown),
        "triangles": rest_body.shown_only(mesh_arrays.read_triangles(skin.data), data.shown),
    }


def _regional(name: str, of_mesh: float, rig: RigState, painted) -> _sinew.Regional:
    return _sinew.Regional(of_mesh, rig.bone_settings.get(name), painted.get(name))


def _is_elastic(settings, detail: Detail) -> bool:
    return settings.elastic and detail.level == level_of_detail.FULL


def _elasticity(mesh, settings, iterations: int, rig: RigState, data: SkinData) -> _sinew.Elasticity:
    painted = data.painted
    return _sinew.Elasticity(
        rest_body.shown_only(mesh_arrays.read_edges_and_diagonals(mesh, data.edges), data.shown),
        rest_body.shown_only(mesh_arrays.read_triangles(mesh), data.shown),
        rig.rest.segments,
        rig.rest.lengths,
        iterations,
        energy=settings.energy,
        anchor_stiffness=_regional("anchor_stiffness", settings.anchor_stiffness, rig, painted),
        edge_stiffness=_regional("edge_stiffness", settings.edge_stiffness, rig, painted),
        slack=_regional("slack", settings.slack, rig, painted),
        relaxation=_regional("relaxation", 1.0, rig, painted),
        fat_sliding=_regional("fat_sliding", settings.fat_sliding, rig, painted),
        volume=rig.bone_settings.get("keep_volume"),
        crease=rig.bone_settings.get("crease"),
        contact=rig.bone_settings.get("contact"),
        contacts=settings.contacts,
        safeguard=settings.safeguard,
    )


def bind_settings(values, detail: Detail, rig_size: float) -> tuple:
    """All settings of a mesh that `bind` reads. values, detail: as for `bind`."""
    settings = values.sinew.skin
    return (
        settings.anchoring,
        settings.motion_source,
        settings.scale_fat,
        settings.muscle_influence,
        _is_elastic(settings, detail),
        detail.iterations if _is_elastic(settings, detail) else 0,
        settings.energy,
        settings.anchor_stiffness,
        settings.edge_stiffness,
        settings.slack,
        settings.fat_sliding,
        settings.contacts,
        settings.safeguard,
        _lengths(settings, rig_size),
    )


def weight_sources_of(skin, values) -> tuple:
    """The settings that decide which vertex groups are bone weights, and how they are used. values: as for `bind`."""
    return armature_modifier.modifier_state(values), rest_body.mask_state(values), skin.vertex_groups.keys()


def _lengths(settings, rig_size: float) -> tuple[float, float]:
    """Falloff and softness in armature space. A falloff of 0 follows the size of the rig, as the softness always does."""
    return settings.falloff or FALLOFF_OF_RIG_SIZE * rig_size, SOFTNESS_OF_RIG_SIZE * rig_size


def _same_masks(before: np.ndarray | None, now: np.ndarray | None) -> bool:
    return before is now or (before is not None and now is not None and np.array_equal(before, now))


def is_same_transform(before: np.ndarray, now: np.ndarray, size: float) -> bool:
    """Whether two transforms of a mesh to armature space differ by rounding only. size: of the rig."""
    if np.array_equal(before, now):
        return True
    # far from the world's origin, rounding changes the transforms of a character in every frame
    tolerance = SAME_POSITION_OF_RIG_SIZE * np.array([1.0, 1.0, 1.0, max(size, 1e-3)])[:, None]
    return bool((np.abs(before - now) <= tolerance * max(1.0, float(np.abs(before[:3]).max()))).all())
