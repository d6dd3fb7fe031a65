# SPDX-License-Identifier: GPL-3.0-or-later
"""`sinew.load_musculature` loads a musculature file."""

from bpy.props import BoolProperty, StringProperty
from bpy.types import Operator
from bpy_extras.io_utils import ImportHelper

from ..muscles.file import reader
from ..scene.linked_data import writable
from .base import SinewOperator, chosen_file, rig_of_context


class SINEW_OT_load_musculature(SinewOperator, ImportHelper, Operator):
    """Load the tissues and skin settings of a file. Tissues are scaled to the proportions of the armature"""

    bl_idname, bl_label = "sinew.load_musculature", "Load Musculature"
    bl_options = {"REGISTER", "UNDO"}

    filename_ext = ".json"
    filter_glob: StringProperty(default="*.json", options={"HIDDEN"})
    replace_all: BoolProperty(
        name="Replace All",
        description="Remove all existing tissues of the armature. Off: only tissues with the same names are replaced",
        default=True,
    )

    def run(self, context):
        problems = {}
        rig = writable(rig_of_context(context))
        path = chosen_file(self.filepath)
        empties = reader.load(rig, path, self.replace_all, problems)
        self.warn(problems)
        return f"{len(empties)} tissues loaded from {path.name}"
