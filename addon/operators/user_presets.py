# SPDX-License-Identifier: GPL-3.0-or-later
"""The presets of this user: `sinew.save_preset`, `sinew.load_preset`, `sinew.rename_preset`, `sinew.delete_preset`."""

from bpy.props import BoolProperty, EnumProperty, StringProperty
from bpy.types import Operator

from ..display import shaded, thumbnail
from ..errors import SinewError
from ..muscles import preset_assets, user_presets
from ..scene.linked_data import writable
from . import preset_items
from .base import SinewOperator, Translated, is_in_window, rig_of_context


def _preset_property():
    return EnumProperty(name="Preset", description="One of your presets", items=preset_items.of_user)


def _finish(operator, context, change, message: str):
    """Changes files of presets, and reports it. They need no character, so the operators are always active.

    Looking for presets in a poll would cost time in every redraw; the error says how to make one.
    """
    try:
        change()
    except (SinewError, OSError) as error:
        operator.report({"ERROR"}, str(error))
        return {"CANCELLED"}
    _follow()
    for area in context.screen.areas if context.screen else ():
        area.tag_redraw()
    operator.report({"INFO"}, message)
    return {"FINISHED"}


def _draw_thumbnail(rig, name: str, context):
    """Draws the picture of a preset that was saved, if its muscles are shown in a window."""
    muscles = shaded.find(rig)
    if muscles is not None and is_in_window():
        thumbnail.write(user_presets.picture_of(name), muscles, context)


def _follow():
    """Updates what shows the presets: menus, and the library of assets if there is one."""
    preset_items.forget()
    if preset_assets.exists():
        preset_assets.write()


class SINEW_OT_save_preset(SinewOperator, Operator):
    """Save the tissues of the armature as a preset of yours, which every character can load"""

    bl_idname, bl_label, bl_options = "sinew.save_preset", "Save as Preset", {"REGISTER"}
    needs_tissues = True

    name: StringProperty(name="Name", description="Name of the preset", default="My Muscles")
    replace: BoolProperty(name="Replace", description="Replace a preset of the same name", default=False)

    def invoke(self, context, _event):
        return context.window_manager.invoke_props_dialog(self)

    def run(self, context):
        problems: dict[str, str] = {}
        try:
            count = user_presets.save(rig_of_context(context), self.name, self.replace, problems)
        except OSError as error:
            raise SinewError(f"The preset can't be written: {error}") from error
        self.warn(problems)
        _draw_thumbnail(rig_of_context(context), self.name, context)
        _follow()
        return f"{count} tissues saved as preset '{self.name}'"


class SINEW_OT_load_preset(SinewOperator, Operator):
    """Add the tissues of a preset of yours, scaled to the proportions of the armature"""

    bl_idname, bl_label = "sinew.load_preset", "Load Preset"

    preset: _preset_property()
    replace_all: BoolProperty(
        name="Replace All",
        description="Remove all existing tissues of the armature. Off: only tissues with the same names are replaced",
        default=False,
    )

    def run(self, context):
        problems: dict[str, str] = {}
        empties = user_presets.load(writable(rig_of_context(context)), self.preset, self.replace_all, problems)
        self.warn(problems)
        return f"{len(empties)} tissues added from preset '{self.preset}'"


class SINEW_OT_rename_preset(Translated, Operator):
    """Rename a preset of yours"""

    bl_idname, bl_label, bl_options = "sinew.rename_preset", "Rename Preset", {"REGISTER"}

    preset: _preset_property()
    name: StringProperty(name="New Name", description="The new name of the preset")

    def invoke(self, context, _event):
        return context.window_manager.invoke_props_dialog(self)

    def execute(self, context):
        old, new = self.preset, self.name
        return _finish(self, context, lambda: user_presets.rename(old, new), f"Preset '{old}' renamed")


class SINEW_OT_delete_preset(Translated, Operator):
    """Delete the file of a preset of yours. Characters keep their tissues"""

    bl_idname, bl_label, bl_options = "sinew.delete_preset", "Delete Preset", {"REGISTER"}

    preset: _preset_property()

    def invoke(self, context, _event):
        return context.window_manager.invoke_props_dialog(self)

    def execute(self, context):
        name = self.preset
        return _finish(self, context, lambda: user_presets.delete(name), f"Preset '{name}' deleted")
