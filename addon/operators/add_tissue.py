# SPDX-License-Identifier: GPL-3.0-or-later
"""`sinew.add_tissue` adds a muscle between two bones, or another tissue on each selected bone."""

from bpy.props import EnumProperty, FloatProperty, StringProperty
from bpy.types import Operator

from ..errors import SinewError
from ..muscles import edit
from ..muscles.placing.fit import fit
from ..muscles.placing.fit.skin_surface import SkinSurface
from ..muscles.placing.place import single
from ..scene import bone_geometry, selection
from ..scene.linked_data import writable
from ..settings.tissue_settings import TISSUE_KINDS
from ..skin.main_skin import skins_to_fit
from . import base
from .base import SinewOperator, rig_of_context
from .tissue_options import ALONG, FIT_SKIN


class SINEW_OT_add_tissue(SinewOperator, Operator):
    """Add a muscle between two selected bones (origin first, insertion last), or another tissue on each selected bone"""

    bl_idname, bl_label = "sinew.add_tissue", "Add Tissue"

    kind: EnumProperty(name="Kind", description="The kind of tissue to add", items=TISSUE_KINDS, default="MUSCLE")
    name: StringProperty(name="Name", description="Name of the tissue. Empty: named after its bone")
    origin_bone: StringProperty(
        name="Origin Bone",
        description="The bone that carries the tissue. Empty: the selected bone; of two, the one selected first",
    )
    insertion_bone: StringProperty(
        name="Insertion Bone", description="The bone that the muscle moves. Empty: the active bone"
    )
    along: ALONG
    around: FloatProperty(
        name="Around",
        description="Side of the bone where the muscle is placed, as an angle from the bone's local Z axis",
        subtype="ANGLE",
    )
    offset: FloatProperty(
        name="Offset",
        description="Distance of the muscle from the bones, as a fraction of its length",
        min=0.0,
        soft_max=0.5,
        default=0.1,
    )
    fit_skin: FIT_SKIN

    def run(self, context):
        rig = writable(rig_of_context(context))
        shapes = [self._shape(rig, *bones) for bones in self._bones(context, rig)]
        skins = skins_to_fit(rig) if self.fit_skin else []
        if skins:
            surface = SkinSurface.of_all(skins, rig)
            shapes = [fit.fit(shape, surface) for shape in shapes]
        empties = edit.add(rig, shapes)
        if base.is_in_window():
            selection.choose(empties[-1])  # it is shown, and Pose Mode stays
        return f"Added {', '.join(empty.name for empty in empties)}"

    def _bones(self, context, rig) -> list[tuple[str, str]]:
        """(origin bone, insertion bone) of each tissue to add."""
        for name in filter(None, (self.origin_bone, self.insertion_bone)):
            if not bone_geometry.has_bone(rig, name):
                raise SinewError(f"{rig.name} has no bone '{name}'")
        selected = [bone.name for bone in context.selected_pose_bones or () if bone.id_data == rig]
        if self.kind != "MUSCLE":
            bones = [self.origin_bone] if self.origin_bone else selected
            if not bones:
                raise SinewError("Select a bone in Pose Mode, or name one as Origin Bone")
            return [(bone, bone) for bone in bones]
        if self.origin_bone and self.insertion_bone:
            pair = (self.origin_bone, self.insertion_bone)
        elif len(selected) == 2:
            active = context.active_pose_bone
            last = active.name if active and active.name in selected else bone_geometry.lower_of(rig, *selected)
            first = next(bone for bone in selected if bone != last)
            pair = (self.origin_bone or first, self.insertion_bone or last)
        else:
            raise SinewError(
                f"A muscle needs two bones, but {len(selected)} are selected. In Pose Mode, select the origin bone, "
                "then Shift-click the insertion bone"
            )
        if pair[0] == pair[1]:
            raise SinewError(f"A muscle needs two different bones, but its origin and insertion are both on '{pair[0]}'")
        return [pair]

    def _shape(self, rig, origin_bone: str, insertion_bone: str):
        if self.kind == "MUSCLE":
            shape = single.muscle(rig, origin_bone, insertion_bone, self.along, self.around, self.offset)
        else:
            shape = single.rigid(rig, self.kind, origin_bone)
        return single.renamed(shape, self.name) if self.name else shape
