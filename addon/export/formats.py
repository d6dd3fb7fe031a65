# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender's own exporters, with the settings that keep what Sinew bakes.

Of their defaults these lose something: applying modifiers takes shape keys away; FBX thins out keys and adds a bone at each chain's
end; glTF leaves out weights beyond four bones and writes each action by itself, so that a skeleton and the keys of its skin end up
in two clips; USD and Alembic write the frame that is shown.
"""

import re
from contextlib import contextmanager
from pathlib import Path

import bpy

from ..errors import SinewError
from ..files.atomic_write import atomic_path

SUFFIXES = {"GLTF": ".glb", "FBX": ".fbx", "USD": ".usdc", "ALEMBIC": ".abc"}
# bones and keys leave Blender as such; the others hold the points of each frame
RIGGED = frozenset({"GLTF", "FBX", "USD"})
_NO_NAME_OF_USD = re.compile(r"\W", re.ASCII)


def write(file_format: str, path: Path, influences: int, every_action: bool, scene):
    """Writes the selected objects, over the scene's frames, into a file that is there whole or not at all.

    influences: bones a vertex, in glTF. every_action: each of the armature's actions is a clip of its own. Raises SinewError.
    """
    if not path.parent.is_dir():
        raise SinewError(f"There is no folder {path.parent}: make it, or choose another")
    with atomic_path(path) as unfinished:
        try:
            _WRITERS[file_format](str(unfinished), influences, every_action, scene)
        except RuntimeError as error:  # what an exporter reports
            raise SinewError(f"{path.name} was not written. {str(error).strip()}") from error
        if not unfinished.is_file():
            raise SinewError(
                f"{path.name} was not written: may {path.parent} be written to? Blender's exporter left no file there"
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
    with _names_of_usd([found.data.shape_keys for found in bpy.context.selected_objects if found.type == "MESH"]):
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
def _names_of_usd(all_keys: list):
    """Keys named as USD can name them while the context lasts.

    Blender's exporter makes "+30" and "-30" the same name, and then no key is read any more.
    """
    before = {}
    for keys in filter(None, all_keys):
        for key in keys.key_blocks:
            wanted = _NO_NAME_OF_USD.sub("_", key.name.replace("+", "plus").replace("-", "minus").replace(".", "point"))
            if wanted != key.name:
                before[key] = key.name
                key.name = wanted
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
