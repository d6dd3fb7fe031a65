# SPDX-License-Identifier: GPL-3.0-or-later
"""`sinew.repair` does what the panel advises: each problem that it names has a button beside it."""

import bpy
from bpy.props import EnumProperty, StringProperty
from bpy.types import Operator

from ..display import views
from ..errors import SinewError
from ..languages.messages import translated
from ..scene import characters, selection
from ..settings import preferences
from ..skin import binding
from .base import Translated

REPAIRS = (
    ("ACTIVATE", "Select It", "Make the object active, as a click on it does"),
    ("SELECT_TISSUE", "Show", "Select the tissue, to correct its settings"),
    ("BIND_AGAIN", "Bind Again", "Bind the mesh again, with its settings"),
    ("SINGLE_USER", "Make Single User", "Give the object its own copy of the mesh"),
    ("LEAVE_EDIT_MODE", "Leave Edit Mode", "Return to Object Mode"),
    ("SHOW_POSE", "Show the Pose", "Leave the rest pose of the armature"),
    ("MATERIAL_COLORS", "Show Material Colors", "Color the solid viewport by material, which X-ray needs"),
    ("LIVE", "Turn On Live", "Deform the skin in every frame again. Baked keys are muted"),
    ("ENABLE", "Turn On Sinew", "Deform skins and show muscles again"),
    ("POSE_MODE", "Pose It", "Make the armature active and enter Pose Mode. Its bones are drawn in front of shown muscles"),
)


class SINEW_OT_repair(Translated, Operator):
    """Do what the panel advises about a problem"""

    bl_idname, bl_label, bl_options = "sinew.repair", "Repair", {"REGISTER", "UNDO", "INTERNAL"}

    what: EnumProperty(name="Repair", description="What to do about the problem", items=REPAIRS, default="ACTIVATE")
    name: StringProperty(name="Object", description="The name of the object that has the problem")

    @classmethod
    def description(cls, _context, properties):
        return translated(next(tip for what, _label, tip in REPAIRS if what == properties.what))

    def execute(self, context):
        found = context.view_layer.objects.get(self.name)
        try:
            if found is None:
                raise SinewError(f"{self.name} is not in this view layer. Enable its collection, or undo its deletion")
            _DO[self.what](context, found)
        except SinewError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        return {"FINISHED"}


def label_of(what: str) -> str:
    """The text of the button of a repair."""
    return next(label for identifier, label, _tip in REPAIRS if identifier == what)


def _activate(context, found):
    _leave_mode(context)
    for selected in context.view_layer.objects.selected:
        selected.select_set(False)
    if not found.visible_get():
        found.hide_set(False)
    found.select_set(True)
    context.view_layer.objects.active = found


def _leave_mode(context, _found=None):
    if context.view_layer.objects.active and context.view_layer.objects.active.mode != "OBJECT":
        bpy.ops.object.mode_set(mode="OBJECT")


def _bind_again(context, skin):
    binding.check_bindable(skin)
    binding.bind(skin, context.evaluated_depsgraph_get())


def _make_single_user(_context, skin):
    if skin.library or skin.data.library:
        raise SinewError(f"{skin.name} is linked from another file. Make it local first (Object > Relations)")
    skin.data = skin.data.copy()
    characters.forget()


def _show_pose(_context, rig):
    if rig.data.library:
        raise SinewError(f"{rig.data.name} is linked from another file. Make a library override of it first")
    rig.data.pose_position = "POSE"


def _show_material_colors(context, _found):
    if context.space_data is None or context.space_data.type != "VIEW_3D":
        raise SinewError("Use it in a 3D viewport")
    context.space_data.shading.color_type = "MATERIAL"


def _turn_on_live(_context, skin):
    skin.sinew.skin.live = True


def _enable(_context, _found):
    stored = preferences.current()
    if stored is None:
        raise SinewError("Sinew has no preferences here. Enable the extension in the preferences")
    stored.is_enabled = True


def _pose_mode(context, rig):
    if context.view_layer.objects.active != rig:
        _activate(context, rig)
    bpy.ops.object.mode_set(mode="POSE")
    if views.of(rig) != views.SKIN and not rig.library:
        rig.show_in_front = True  # muscles would hide the bones, and a hidden bone can't be clicked


_DO = {
    "ACTIVATE": _activate,
    "SELECT_TISSUE": lambda _context, tissue: selection.select(tissue),
    "BIND_AGAIN": _bind_again,
    "SINGLE_USER": _make_single_user,
    "LEAVE_EDIT_MODE": _leave_mode,
    "SHOW_POSE": _show_pose,
    "MATERIAL_COLORS": _show_material_colors,
    "LIVE": _turn_on_live,
    "ENABLE": _enable,
    "POSE_MODE": _pose_mode,
}
