# SPDX-License-Identifier: GPL-3.0-or-later
"""The next step: what can be done with the character in its current state, as large buttons."""

import bpy

from ..scene import characters
from .sidebar import label_wrapped

NO_FILE, NO_CHARACTER, RIG, MUSCLES, BOUND = "NO_FILE", "NO_CHARACTER", "RIG", "MUSCLES", "BOUND"
MOST_RIGS = 4
LARGE = 1.4  # height of the button of the next step over that of others
# an importer is drawn if this Blender has it: Blender 5 replaced the FBX importer
_IMPORTERS = (("wm.fbx_import", "Import FBX"), ("import_scene.fbx", "Import FBX"), ("import_scene.gltf", "Import glTF"))


def of(context, rig) -> str:
    """The state of the character. rig: the armature of the context, or None."""
    if rig is None:
        return NO_CHARACTER if _rigs(context) else NO_FILE
    character = characters.last_character_of(rig)
    if character is None or not (character.tissues or character.skins):
        return RIG
    return BOUND if character.skins else MUSCLES


def draw(layout, context, rig, reason: str):
    """Draws what can be done next. reason: why there is no armature in the context."""
    state = of(context, rig)
    if state == BOUND and rig.mode == "POSE":
        label_wrapped(layout, "Click a bone and rotate it (R), or drag its end (Reach)", "INFO")
    column = layout.column(align=True)
    column.scale_y = LARGE
    if state == NO_FILE:
        column.operator("sinew.example_character", icon="OUTLINER_OB_ARMATURE")
        label_wrapped(layout, "Or import a character:", "INFO")
        _draw_importers(layout.column(align=True))
    elif state == NO_CHARACTER:
        label_wrapped(layout, reason, "INFO")
        for found in _rigs(context)[:MOST_RIGS]:
            choice = layout.operator("sinew.repair", text=found.name, icon="ARMATURE_DATA", translate=False)
            choice.what, choice.name = "ACTIVATE", found.name
    elif state == RIG:
        column.operator("sinew.add_muscles", icon="OUTLINER_OB_ARMATURE")
        column = layout.column(align=True)
        column.operator_menu_enum("sinew.add_preset", "name", text="Add Preset", icon="PRESET")
        column.operator("sinew.add_automatic", icon="AUTO")
        column.operator_menu_enum("sinew.add_tissue", "kind", text="Add Tissue", icon="ADD")
        column.operator("sinew.draw_muscle", icon="GREASEPENCIL")
    elif state == MUSCLES:
        column.operator("sinew.bind", icon="LINKED")
        layout.operator("sinew.grow_skin", text="Grow a Skin Instead", icon="OUTLINER_OB_META")
    else:
        _draw_bound(column, layout, rig)


def _draw_bound(column, layout, rig):
    if rig.mode == "POSE":
        column.operator("sinew.reach", icon="CON_KINEMATIC")
    else:
        pose = column.operator("sinew.repair", text="Pose It", icon="POSE_HLT")
        pose.what, pose.name = "POSE_MODE", rig.name
    layout.operator("sinew.range_of_motion", icon="ANIM")


def _draw_importers(column):
    drawn = set()
    for identifier, text in _IMPORTERS:
        module, name = identifier.split(".")
        if text not in drawn and hasattr(bpy.types, f"{module.upper()}_OT_{name}"):
            column.operator(identifier, text=text, icon="IMPORT")
            drawn.add(text)


def _rigs(context) -> list:
    return [found for found in context.view_layer.objects if found.type == "ARMATURE"]
