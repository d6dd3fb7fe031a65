# SPDX-License-Identifier: GPL-3.0-or-later
"""Groups of tissues: `sinew.group_tissues` makes them, `select_group` selects one, `key_group` keys its tension."""

from bpy.props import EnumProperty, StringProperty
from bpy.types import Operator

from ..errors import SinewError
from ..muscles import groups
from ..scene import selection, tissue_empty
from ..scene.linked_data import writable
from ..settings import group_settings
from .base import SinewOperator, rig_of_context

TENSION = "sinew.tissue.tension"
BY = (
    ("REGION", "By Region", "Arms, legs, trunk and head, as recognized from the bones"),
    ("SELECTED", "Selected", "The selected tissues become one group"),
)


class SINEW_OT_group_tissues(SinewOperator, Operator):
    """Put the tissues of the armature into groups, whose muscles can be muted, tensed and edited together"""

    bl_idname, bl_label = "sinew.group_tissues", "Group Tissues"
    needs_tissues = True

    by: EnumProperty(name="By", description="Which tissues belong together", items=BY, default="REGION")
    name: StringProperty(name="Name", description="Name of the group of the selected tissues", default="Group")

    def run(self, context):
        rig = writable(rig_of_context(context))
        if self.by == "SELECTED":
            chosen = [found for found in context.selected_objects if tissue_empty.is_tissue(found) and found.parent == rig]
            if not chosen:
                raise SinewError("No tissue is selected. Select the tissues of the group, or group by region")
            of_tissue = {tissue.name: self.name for tissue in chosen}
        else:
            of_tissue = groups.by_region(rig)
        for tissue in rig.children:
            if tissue.name in of_tissue:
                tissue.sinew.tissue.group = of_tissue[tissue.name]
        names = groups.names(rig)
        group_settings.follow(rig, names)
        return f"{len(of_tissue)} tissues of {rig.name} are in {len(set(of_tissue.values()))} groups"


class GroupOperator(SinewOperator):
    """Mix-in: an operator on one group of the context's armature."""

    needs_tissues = True
    group: StringProperty(name="Group", description="Name of the group of tissues")


class SINEW_OT_select_group(GroupOperator, Operator):
    """Select all tissues of a group, to move, rotate or scale them together, or to copy settings to them"""

    bl_idname, bl_label = "sinew.select_group", "Select Group"

    def run(self, context):
        rig = rig_of_context(context)
        found = groups.require_members(rig, self.group)
        if not rig.library:
            rig.sinew.rig.show_empties = True  # hidden objects can't be selected
        selection.select(found[0])
        for tissue in found:
            if context.view_layer.objects.get(tissue.name) == tissue:
                tissue.select_set(True)
        return f"{len(found)} tissues selected"


class SINEW_OT_key_group(GroupOperator, Operator):
    """Insert a key for the tension of each muscle of a group at the current frame"""

    bl_idname, bl_label = "sinew.key_group", "Key Tension of Group"

    def run(self, context):
        rig = rig_of_context(context)
        muscles = [found for found in groups.require_members(rig, self.group) if found.sinew.tissue.kind == "MUSCLE"]
        linked = [muscle.name for muscle in muscles if muscle.library]
        if linked:
            raise SinewError(f"{linked[0]} is linked from another file. Make a library override of its armature first")
        for muscle in muscles:
            muscle.keyframe_insert(TENSION)
        return f"Tension of {len(muscles)} muscles keyed at frame {context.scene.frame_current}"
