# SPDX-License-Identifier: GPL-3.0-or-later
"""`sinew.save_musculature` saves a musculature file."""

from bpy.props import StringProperty
from bpy.types import Operator
from bpy_extras.io_utils import ExportHelper

from ..muscles.file import writer
from .base import SinewOperator, chosen_file, rig_of_context


class SINEW_OT_save_musculature(SinewOperator, ExportHelper, Operator):
    """Save the tissues and skin settings of the armature to a text file, which other characters can load"""

    bl_idname, bl_label = "sinew.save_musculature", "Save Musculature"
    bl_options = {"REGISTER"}  # the scene does not change
    needs_tissues = True

    filename_ext = ".json"
    filter_glob: StringProperty(default="*.json", options={"HIDDEN"})

    def run(self, context):
        problems = {}
        path = chosen_file(self.filepath)
        count = writer.save(rig_of_context(context), path, problems)
        self.warn(problems)
        return f"{count} tissues saved to {path.name}"
