# SPDX-License-Identifier: GPL-3.0-or-later
"""`sinew.export`

    bpy.ops.sinew.export(filepath="body.glb", format="GLTF", influences="4", clips="PLAYED")

writes the export copy of the active armature (see `sinew.bake_bones`), or, where there is none, the armature with its bound meshes
and what is baked on them. Alembic holds the points of each frame, live ones where nothing is baked.
"""

from pathlib import Path

import bpy
from bpy.props import EnumProperty, StringProperty
from bpy.types import Operator
from bpy_extras.io_utils import ExportHelper

from ..errors import SinewError
from ..export import export_copy, formats
from ..export.restore_context import restored_context, select, show
from ..scene import armature_modifier, characters
from .bake_bones import INFLUENCES
from .base import SinewOperator, rig_of_context

FORMATS = (
    ("GLTF", "glTF", "Bones, muscle bones, keys and their played values, in one .glb: web, Godot, Unity, Unreal"),
    ("FBX", "FBX", "Bones, muscle bones, keys and their played values: Unreal, Unity, Maya"),
    ("USD", "USD", "Bones, muscle bones and keys as UsdSkel, in one .usdc"),
    ("ALEMBIC", "Alembic", "The points of each frame, live or baked: renderers, Houdini"),
)
CLIPS = (
    ("PLAYED", "What Plays", "One clip of what the scene plays: bones and keys together"),
    ("ACTIONS", "All Actions", "A clip for each action of the armature, in glTF and FBX; correctives follow each"),
)


class SINEW_OT_export(SinewOperator, ExportHelper, Operator):
    """Export what is baked with the settings that keep it: bones, muscle bones, keys and their values over the scene's frames"""

    bl_idname, bl_label = "sinew.export", "Export Baked"
    bl_options = {"REGISTER"}  # nothing in the scene changes

    filename_ext = ".glb"
    filter_glob: StringProperty(default="*.glb;*.fbx;*.usdc;*.abc", options={"HIDDEN"})
    format: EnumProperty(name="Format", items=FORMATS, default="GLTF")
    influences: EnumProperty(name="Influences", description="Bones a vertex in glTF", items=INFLUENCES, default="4")
    clips: EnumProperty(name="Clips", description="What is played in the file", items=CLIPS, default="PLAYED")

    def check(self, _context):
        wanted = (
            str(Path(self.filepath).with_suffix(formats.SUFFIXES[self.format]))
            if Path(self.filepath).name
            else self.filepath
        )
        changed, self.filepath = wanted != self.filepath, wanted
        return changed

    def run(self, context):
        rig = rig_of_context(context)
        path = Path(bpy.path.abspath(self.filepath)).with_suffix(formats.SUFFIXES[self.format])
        collection = export_copy.find(rig)
        with restored_context(context):
            if collection:
                shown = show(context.view_layer, collection, True)
                try:
                    self._write(context, [*export_copy.skins_in(collection), export_copy.rig_in(collection)], path)
                finally:
                    show(context.view_layer, collection, shown)
                return f"{collection.name} written to {path.name}"
            skins = [skin for skin in characters.skins_of(rig) if armature_modifier.is_bound(skin)]
            if not skins:
                raise SinewError(f"{rig.name} has no bound mesh to export: bind one first (Bind Skin)")
            baked = [skin for skin in skins if len(skin.sinew.baked_keys)]
            if not baked and self.format in formats.RIGGED:
                raise SinewError(
                    f"Nothing of {rig.name} is baked, and {self.format} keeps no live skin: bake shape keys, correctives or muscle "
                    "bones first, or export Alembic"
                )
            live = {skin.name: skin.sinew.live for skin in baked}
            try:
                for skin in baked:
                    skin.sinew.live = False
                self._write(context, [*skins, rig], path)
            finally:
                for name, was_live in live.items():
                    bpy.data.objects[name].sinew.live = was_live
        return f"{rig.name} written to {path.name}"

    def _write(self, context, objects: list, path: Path):
        if None in objects:
            raise SinewError("The armature of the export copy was deleted: bake muscle bones again")
        hidden = [found.name for found in objects if not found.visible_get()]
        if hidden:
            raise SinewError(f"{', '.join(hidden)} is hidden, and exporters leave out what is: show it")
        select(context.view_layer, objects, objects[-1])
        formats.write(self.format, path, int(self.influences), self.clips == "ACTIONS", context.scene)
