# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs Blender's exporters with the settings that keep everything that Sinew bakes.

Their defaults lose data. Applying modifiers removes shape keys. FBX simplifies keyframes and adds a bone at the end of
each chain. glTF drops weights beyond four bones per vertex and writes each action by itself, so that a skeleton and the
keys of its skin end up in two clips. USD and Alembic write only the current frame.
"""

import re
from contextlib import contextmanager
from pathlib import Path

import bpy

from ..errors import SinewError
from ..files.atomic_write import atomic_path
from . import compact_morphs

SUFFIXES = {"GLTF": ".glb", "FBX": ".fbx", "USD": ".usdc", "ALEMBIC": ".abc"}
# formats that store bones and keys; Alembic stores the points of each frame
RIGGED = frozenset({"GLTF", "FBX", "USD"})
_INVALID_IN_USD = re.compile(r"\W", re.ASCII)


def write(file_format: str, path: Path, influences: int, every_action: bool, scene):
    """Writes the selected objects, over the scene's frames, to a file that is complete or does not exist.

    influences: the number of bones per vertex, for glTF. every_action: write each of the armature's actions as a clip.
    Raises SinewError if the exporter fails.
    """
    if not path.parent.is_dir():
        raise SinewError(f"There is no folder {path.parent}. Make it, or choose another")
    with atomic_path(path) as unfinished:
        try:
            _WRITERS[file_format](str(unfinished), influences, every_action, scene)
        except RuntimeError as error:  # the error report of an exporter
            raise SinewError(f"{path.name} was not written. {str(error).strip()}") from error
        if not unfinished.is_file():
            raise SinewError(
                f"{path.name} was not written: Blender's exporter made no file. Check that {path.parent} is writable"
            )


def _gltf(path: str, influences: int, every_action: bool, scene):
    bpy.ops.export_scene.gltf(
        filepath=path,
        export_format="GLB",
        use_selection=True,
        export_apply=False,
        export_animation_mode="ACTIONS" if every_action else "ACTIVE_ACTIONS",
        export_nla_strips_merged_animation_name=scene.name,
        export_frame_range=True,
        export_anim_slide_to_zero=True,
        export_force_sampling=True,
        export_optimize_animation_size=False,
        export_def_bones=True,
        export_influence_nb=influences,
        export_all_influences=False,
        export_morph=True,
        export_morph_normal=True,
        export_morph_animation=True,
        export_morph_reset_sk_data=True,
        export_try_sparse_sk=True,
        export_rest_position_armature=True,
    )
    compact_morphs.compact(Path(path))


def _fbx(path: str, _influences: int, every_action: bool, _scene):
    bpy.ops.export_scene.fbx(
        filepath=path,
        use_selection=True,
        object_types={"ARMATURE", "MESH"},
        use_mesh_modifiers=False,
        add_leaf_bones=False,
        use_armature_deform_only=True,
        bake_anim=True,
        bake_anim_use_all_bones=True,
        bake_anim_use_nla_strips=every_action,
        bake_anim_use_all_actions=every_action,
        bake_anim_force_startend_keying=True,
        bake_anim_simplify_factor=0.0,
    )


def _usd(path: str, _influences: int, _every_action: bool, _scene):
    with _usd_names([each.data.shape_keys for each in bpy.context.selected_objects if each.type == "MESH"]):
        bpy.ops.wm.usd_export(
            filepath=path,
            selected_objects_only=True,
            export_animation=True,
            export_armatures=True,
            only_deform_bones=True,
            export_shapekeys=True,
            export_subdivision="IGNORE",
            evaluation_mode="RENDER",
        )


@contextmanager
def _usd_names(all_keys: list):
    """Gives shape keys names that are valid in USD until the block ends.

    Blender's exporter turns "+30" and "-30" into the same name, and then no key can be read from the file.
    """
    before = {}
    for keys in filter(None, all_keys):
        for key in keys.key_blocks:
            valid = _INVALID_IN_USD.sub("_", key.name.replace("+", "plus").replace("-", "minus").replace(".", "point"))
            if valid != key.name:
                before[key] = key.name
                key.name = valid
    try:
        yield
    finally:
        for key, name in before.items():
            key.name = name


def _alembic(path: str, _influences: int, _every_action: bool, scene):
    bpy.ops.wm.alembic_export(
        filepath=path,
        selected=True,
        start=scene.frame_start,
        end=scene.frame_end,
        flatten=False,
        evaluation_mode="RENDER",
        as_background_job=False,
    )


_WRITERS = {"GLTF": _gltf, "FBX": _fbx, "USD": _usd, "ALEMBIC": _alembic}
