# SPDX-License-Identifier: GPL-3.0-or-later
"""`sinew.export` exports the baked character to glTF, FBX, USD or Alembic.

    bpy.ops.sinew.export(filepath="body.glb", format="GLTF", influences="4", clips="PLAYED")

The operator writes the export copy of the active armature (see `sinew.bake_bones`). Without a copy it writes the armature
with its bound meshes and their baked data. Alembic stores the points of each frame, including those of a live skin.
"""

from pathlib import Path

import bpy
from bpy.props import EnumProperty, StringProperty
from bpy.types import Operator
from bpy_extras.io_utils import ExportHelper

from ..errors import SinewError
from ..export import applied_modifiers, export_copy, file_copies, followers, formats, scales
from ..export.restore_context import restored_context, select, show
from ..scene import armature_modifier, characters
from .bake_bones import INFLUENCES
from .base import SinewOperator, chosen_file, rig_of_context

FORMATS = (
    (
        "GLTF",
        "glTF",
        "Bones, muscle bones, shape keys and their animation in one .glb file, for web, Godot, Unity and Unreal",
    ),
    ("FBX", "FBX", "Bones, muscle bones, shape keys and their animation, for Unreal, Unity and Maya"),
    ("USD", "USD", "Bones, muscle bones and shape keys as UsdSkel, in one .usdc file"),
    ("ALEMBIC", "Alembic", "Points of each frame, live or baked, for renderers and Houdini"),
)
CLIPS = (
    ("PLAYED", "Scene", "One clip of the scene's animation, with bones and shape keys together"),
    ("ACTIONS", "All Actions", "One clip per action of the armature (glTF and FBX). Correctives follow each action"),
)


class SINEW_OT_export(SinewOperator, ExportHelper, Operator):
    """Export bones, muscle bones and baked shape keys with their animation, using the exporter settings that keep them"""

    bl_idname, bl_label = "sinew.export", "Export Baked"
    bl_options = {"REGISTER"}  # the scene does not change

    filename_ext = ".glb"
    filter_glob: StringProperty(default="*.glb;*.fbx;*.usdc;*.abc", options={"HIDDEN"})
    format: EnumProperty(name="Format", description="Format of the exported file", items=FORMATS, default="GLTF")
    influences: EnumProperty(
        name="Influences", description="Bone influences per vertex (glTF)", items=INFLUENCES, default="4"
    )
    clips: EnumProperty(name="Clips", description="Which animation to export", items=CLIPS, default="PLAYED")

    def check(self, _context):
        """Gives the file name the suffix of the format. Returns whether it changed."""
        if not Path(self.filepath).name:
            return False
        before, self.filepath = self.filepath, str(Path(self.filepath).with_suffix(formats.SUFFIXES[self.format]))
        return self.filepath != before

    def run(self, context):
        rig = rig_of_context(context)
        path = chosen_file(self.filepath).with_suffix(formats.SUFFIXES[self.format])
        collection = export_copy.find(rig)
        with restored_context(context) as go_to:
            if collection:
                shown = show(context.view_layer, collection, True)
                try:
                    self._write_copy(context, rig, collection, path)
                finally:
                    show(context.view_layer, collection, shown)
                return f"{collection.name} written to {path.name}"
            self._write_character(context, rig, path, go_to)
        return f"{rig.name} written to {path.name}"

    def _write_copy(self, context, rig, collection, path: Path):
        rig_copy, skins = export_copy.rig_in(collection), export_copy.skins_in(collection)
        if rig_copy is None:
            raise SinewError("The armature of the export copy was deleted. Bake muscle bones again")
        missing = export_copy.skins_without_copy(rig, collection)
        if missing:
            self.report(
                {"WARNING"}, f"{', '.join(missing)} is not in {collection.name} and so not in the file. Bake it, too"
            )
        self._write(context, rig_copy, skins, followers.of(rig), path)

    def _write_character(self, context, rig, path: Path, go_to):
        skins = [skin for skin in characters.skins_of(rig) if armature_modifier.is_bound(skin)]
        if not skins:
            raise SinewError(f"{rig.name} has no bound mesh to export. Bind one first (Bind Skin)")
        if self.format in formats.RIGGED:
            if not any(len(skin.sinew.skin.baked_keys) for skin in skins):
                raise SinewError(
                    f"{rig.name} has no baked data, and {self.format} cannot store the live skin. Bake shape keys, "
                    "correctives or muscle bones first, or export Alembic"
                )
            if not scales.is_even(rig.matrix_world):
                raise SinewError(
                    f"{rig.name} has an uneven or negative scale in the world, which changes its bones in a file. Apply it "
                    "(Ctrl+A > Scale), or use Bake Muscle Bones, which applies it to the copy"
                )
            if rig.parent and _moves(rig.parent, context.scene, go_to):
                raise SinewError(
                    f"{rig.name} moves with its parent {rig.parent.name}, which is not in the file. Key the motion of the "
                    "armature itself, or use Bake Muscle Bones, which keys it on the copy"
                )
        baked = [skin for skin in skins if len(skin.sinew.skin.baked_keys)]
        live = {skin.name: skin.sinew.skin.live for skin in baked}
        try:
            for skin in baked:
                skin.sinew.skin.live = False
            self._write(context, rig, skins, followers.of(rig), path)
        finally:
            for name, was_live in live.items():
                bpy.data.objects[name].sinew.skin.live = was_live

    def _write(self, context, rig, skins: list, others: list, path: Path):
        """Writes a rig, its skins, and the other meshes of its character."""
        hidden = [exported.name for exported in (*skins, rig) if not exported.visible_get()]
        if hidden:
            raise SinewError(f"Hidden objects are not exported: {', '.join(hidden)}. Show them first")
        scene, layer = context.scene, context.view_layer
        meshes = [*skins, *others]
        if self.format not in formats.RIGGED:
            self._write_objects(context, [*meshes, rig], path)
            return
        for mesh in meshes:
            left_out = applied_modifiers.left_out(mesh)
            if left_out:
                self.report(
                    {"WARNING"},
                    f"{mesh.name}: {', '.join(left_out)} after the Armature modifier is not in the file, which has no "
                    "modifiers. Move it before the Armature modifier, or apply it",
                )
        with file_copies.file_copies(scene, layer, rig, meshes) as copies:
            self._write_objects(context, [*copies, rig], path)

    def _write_objects(self, context, objects: list, path: Path):
        select(context.view_layer, objects, objects[-1])
        formats.write(self.format, path, int(self.influences), self.clips == "ACTIONS", context.scene)


def _moves(parent, scene, go_to) -> bool:
    """Whether an object has another place in the world at the start, the middle or the end of the scene's frames."""
    first, last = scene.frame_start, scene.frame_end
    places = []
    for frame in (first, (first + last) // 2, last):
        go_to(frame)
        places.append(parent.matrix_world.copy())
    return any(place != places[0] for place in places)
