# SPDX-License-Identifier: GPL-3.0-or-later
"""Grows a skin over a rig's tissues: a mesh with weights and UVs, bound and live (Wilhelms 1997).

docs/mathematics/growing.md describes how the surface and its weights are computed.
"""

import threading
from dataclasses import dataclass

import bpy
import _sinew
import numpy as np
from mathutils import Matrix

from ..errors import SinewError
from ..live import session
from ..muscles import edit, portable_names
from ..muscles.placing.place import features
from ..scene import characters, stored_settings, tissue_empty
from ..scene.editable_collections import editable_collections_of
from ..settings import growth_settings
from . import binding, feature_materials, surface_transfer

KEPT_WITHIN_VOXELS = 2.0  # painted data farther than this from the new surface is dropped
SAME_POSITION = 1e-6


@dataclass(frozen=True)
class Summary:
    """The result of growing a skin."""

    skin: str
    faces: int
    grown: _sinew.GrownSkin
    is_new: bool
    problems: dict[str, str]


class Growth:
    """One growth of a skin: `compute` runs in any thread, then `finish` creates the mesh in Blender's main thread."""

    def __init__(self, rig, options, with_features: bool, memory_limit_mb: float):
        """Reads the rig. Raises SinewError if there is nothing to grow over, or if a grown skin can't be replaced.

        with_features: the first skin of a rig gets tissues for eyes, ears and claws, at bones with such names. Later skins
        leave these tissues as the user left them.
        """
        if rig.data.is_editmode:
            raise SinewError(f"{rig.name} is in Edit Mode. Leave it (Tab) and try again")
        if not characters.tissues_of(rig):
            raise SinewError(f"{rig.name} has no tissues to grow a skin over. Add muscles first (Add Preset, Add Tissue)")
        check_replaceable(grown_skin_of(rig))
        if 0 < options.faces < growth_settings.FEWEST_FACES:
            raise SinewError(
                f"{options.faces} faces are too few. Use at least {growth_settings.FEWEST_FACES}, or 0 for no limit"
            )
        self._memory_limit_mb = memory_limit_mb
        self._added: list[str] = []
        if with_features and grown_skin_of(rig) is None:
            named = portable_names.of_rig(rig)
            missing = [shape for shape in features.features(rig) if shape.name not in named]
            self._added = [empty.name for empty in edit.add(rig, missing)] if missing else []
        try:
            self._read(rig, options)
        except SinewError:
            self._remove_added()
            raise

    def _read(self, rig, options):
        tissues = characters.tissues_of(rig)
        try:
            state = session.rig_state(rig, tissues, bpy.context.evaluated_depsgraph_get())
        except ValueError as error:
            raise SinewError(f"{rig.name}: {error}") from error
        if state.musculature is None:
            raise SinewError(f"{rig.name}: none of its tissues can be used. {'. '.join(state.problems.values())}")
        self.options = {name: getattr(options, name) for name in growth_settings.OPTIONS}
        self._rig = rig.name
        self._state = state
        self._thickness = _thickness(rig, [tissues[index] for index in state.solved], options.thickness)
        self._weight_bones = _weight_bones(rig, state.rest)
        self._progress = _sinew.Progress()
        self._grown: _sinew.GrownSkin | None = None
        self._problem: str = ""
        self._thread: threading.Thread | None = None

    @property
    def done(self) -> float:
        """The fraction that is done, 0..1."""
        return self._progress.done

    @property
    def is_computed(self) -> bool:
        return self._thread is None or not self._thread.is_alive()

    def start(self):
        """Starts `compute` in a new thread. It does not access Blender's data."""
        self._thread = threading.Thread(target=self.compute, name="sinew.grow_skin")
        self._thread.start()

    def cancel(self):
        """Ends the growth and leaves the file as it was."""
        self._progress.cancel()
        if self._thread:
            self._thread.join()
        self._remove_added()

    def _remove_added(self):
        edit.remove([bpy.data.objects[name] for name in self._added if name in bpy.data.objects])

    def compute(self):
        """Grows the surface. `finish` raises the error if this fails."""
        options = dict(self.options)
        faces = options.pop("faces")
        options["thickness"] = 0.0  # that of each tissue includes it
        try:
            self._grown = _sinew.GrownSkin(
                self._state.musculature,
                self._thickness,
                self._state.rest.lengths,
                self._weight_bones,
                faces=faces or None,
                memory_limit_mb=self._memory_limit_mb,
                progress=self._progress,
                **options,
            )
        except ValueError as error:
            self._problem = str(error)

    def finish(self, context, elastic: bool, unwrap: bool) -> Summary:
        """Creates the mesh, or gives the grown skin of the rig the new surface.

        Raises SinewError, and leaves the file as it was.
        """
        try:
            rig = bpy.data.objects.get(self._rig)
            if rig is None or self._grown is None:
                raise SinewError(f"{self._rig}: {self._problem or 'the armature was deleted or renamed'}")
            check_replaceable(grown_skin_of(rig))
            return self._make(context, rig, elastic, unwrap)
        except SinewError:
            self._remove_added()
            raise

    def _make(self, context, rig, elastic: bool, unwrap: bool) -> Summary:
        grown, skin = self._grown, grown_skin_of(rig)
        is_new = skin is None
        mesh = _mesh_of(grown, f"{rig.name} Skin" if is_new else skin.data.name)
        if is_new:
            tissues = characters.tissues_of(rig)
            thickness = _thickness(rig, tissues, self.options["thickness"])
            shapes = [tissue_empty.read(empty, rig) for empty in tissues]
            feature_materials.assign(mesh, shapes, thickness, grown.voxel)
            skin = _object_of(rig, mesh)
            skin.sinew.skin.elastic = elastic
        else:
            _replace(skin, mesh, rig, KEPT_WITHIN_VOXELS * grown.voxel)
        growth = skin.sinew.skin.growth
        for name, value in self.options.items():
            setattr(growth, name, value)
        growth.is_grown = True
        _write_weights(skin, grown, self._state.rest)
        if unwrap and not mesh.uv_layers:
            _unwrap(context, skin)
        was_live = is_new or skin.sinew.skin.live
        context.view_layer.update()
        try:
            summary = binding.bind(skin, context.evaluated_depsgraph_get())
        except SinewError:
            if is_new:
                discard(skin)
            raise
        skin.sinew.skin.live = was_live
        return Summary(skin.name, len(mesh.polygons), grown, is_new, summary.problems)


def grown_skin_of(rig):
    """The grown skin of a rig, or None."""
    return next((skin for skin in characters.skins_of(rig) if is_grown(skin)), None)


def is_grown(skin) -> bool:
    """Whether a mesh was grown. Does not create settings on objects that have none."""
    return stored_settings.is_grown(skin)


def check_replaceable(skin):
    """Raises SinewError if the surface of a grown skin can't be replaced. skin: may be None."""
    if skin is None:
        return
    binding.check_bindable(skin)
    if skin.data.shape_keys:
        raise SinewError(
            f"{skin.name} has shape keys, which do not fit another surface. Remove them first (a bake can be repeated)"
        )


def discard(skin):
    """Removes a grown skin with its mesh."""
    mesh = skin.data
    bpy.data.objects.remove(skin)
    if mesh.users == 0:
        bpy.data.meshes.remove(mesh)
    characters.forget()


def _thickness(rig, tissues: list, overall: float) -> np.ndarray:
    """(tissues,) float32: the thickness of the skin over each tissue, m: its own and the overall one, times the bone's."""
    factors = {bone.name: settings.fat_thickness for bone in rig.pose.bones if (settings := stored_settings.bone_of(bone))}
    settings = [empty.sinew.tissue for empty in tissues]
    found = [(overall + tissue.skin_thickness) * factors.get(tissue.origin_bone, 1.0) for tissue in settings]
    return np.array(found, np.float32)


def _weight_bones(rig, rest) -> np.ndarray:
    """(skeleton bones,) int32: the bone that carries each bone's skin weights: itself or the nearest deforming ancestor."""
    weight_bones = np.arange(len(rest.skeleton), dtype=np.int32)
    for bone in rig.data.bones:
        deforming = next((candidate for candidate in (bone, *bone.parent_recursive) if candidate.use_deform), None)
        if deforming is not None:
            weight_bones[rest.index_of_bone[bone.name]] = rest.index_of_bone[deforming.name]
    return weight_bones


def _mesh_of(grown: _sinew.GrownSkin, name: str):
    mesh = bpy.data.meshes.new(name)
    points, quads = grown.points, grown.quads
    mesh.vertices.add(len(points))
    mesh.attributes["position"].data.foreach_set("vector", points.reshape(-1))
    mesh.loops.add(quads.size)
    mesh.loops.foreach_set("vertex_index", quads.reshape(-1))
    mesh.polygons.add(len(quads))
    mesh.polygons.foreach_set("loop_start", np.arange(0, quads.size, 4, dtype=np.int32))
    mesh.update(calc_edges=True)
    mesh.shade_smooth()
    return mesh


def _object_of(rig, mesh):
    """Creates the object of a grown skin, in the space of the armature, with an Armature modifier."""
    skin = bpy.data.objects.new(mesh.name, mesh)
    for collection in editable_collections_of(rig):
        collection.objects.link(skin)
    skin.parent = rig
    skin.modifiers.new("Armature", "ARMATURE").object = rig
    return skin


def _replace(skin, mesh, rig, max_distance: float):
    """Gives a grown skin a new surface, and transfers the user's data from the old one."""
    old_mesh = skin.data
    relation = skin.matrix_world.inverted_safe() @ rig.matrix_world
    if any((relation.col[i] - Matrix().col[i]).length > SAME_POSITION for i in range(4)):
        mesh.transform(relation)  # the object was moved
    surface_transfer.transfer(skin, mesh, {bone.name for bone in rig.data.bones}, max_distance)
    session.forget_skin(skin)
    if old_mesh.users == 0:
        name = old_mesh.name
        bpy.data.meshes.remove(old_mesh)
        mesh.name = name


def _write_weights(skin, grown: _sinew.GrownSkin, rest):
    names = {index: bone for bone, index in rest.index_of_bone.items()}
    vertices = np.repeat(np.arange(len(grown)), np.diff(grown.weight_offsets))
    for index in np.unique(grown.weight_bones).tolist():
        of_bone = grown.weight_bones == index
        group = skin.vertex_groups.new(name=names[index])
        for vertex, weight in zip(vertices[of_bone].tolist(), grown.weights[of_bone].tolist()):
            group.add((vertex,), weight, "REPLACE")


def _unwrap(context, skin):
    """Creates UVs with Smart UV Project, which works only on the active mesh in Edit Mode."""
    layer = context.view_layer
    active, selected = layer.objects.active, list(layer.objects.selected)
    mode = active.mode if active else "OBJECT"
    if mode != "OBJECT":
        bpy.ops.object.mode_set(mode="OBJECT")
    for selected_object in selected:
        selected_object.select_set(False)
    layer.objects.active = skin
    skin.select_set(True)
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.ops.mesh.select_all(action="SELECT")
    bpy.ops.uv.smart_project(island_margin=0.003)
    bpy.ops.object.mode_set(mode="OBJECT")
    skin.select_set(False)
    for selected_object in selected:
        selected_object.select_set(True)
    layer.objects.active = active
    if mode != "OBJECT":
        bpy.ops.object.mode_set(mode=mode)
