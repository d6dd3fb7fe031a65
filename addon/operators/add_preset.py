# SPDX-License-Identifier: GPL-3.0-or-later
"""`sinew.add_preset` adds the musculature of a preset to an armature."""

from bpy.props import EnumProperty
from bpy.types import Operator

from ..errors import SinewError
from ..muscles.placing.place import placement, preset_file
from ..muscles.placing.place.figure import FIGURES
from ..muscles.placing.place.preset_to_rig import populate
from ..muscles.placing.recognise import creature, kind
from ..scene.linked_data import writable
from ..skin.main_skin import skins_to_fit
from . import bone_table, preset_items
from .base import SinewOperator, rig_of_context
from .tissue_options import FIGURE, FIT_SKIN

STRANDS = (
    (placement.SEPARATE, "Separate", "Build one muscle per strand"),
    (placement.JOINED, "Joined", "Join strands of one muscle that run side by side"),
)


class SINEW_OT_add_preset(SinewOperator, Operator):
    """Add the muscles of a preset to the armature and fit them under its mesh. Muscles with the same names are replaced"""

    bl_idname, bl_label = "sinew.add_preset", "Add Preset"

    name: EnumProperty(name="Preset", description="The preset whose muscles are added", items=preset_items.shipped)
    fit_skin: FIT_SKIN
    figure: FIGURE
    strands: EnumProperty(
        name="Strands", description="How to build muscles that the preset stores as several strands", items=STRANDS
    )
    bones: bone_table.bones_property()

    def invoke(self, context, _event):
        """Opens a dialog for the bones if they are not recognised."""
        try:
            rig, preset = rig_of_context(context), preset_file.read(self.name)
            body = bone_table.recognised(self.bones, rig, preset.roles, preset.creature)
            placement.require(preset, body)
        except SinewError as problem:
            if context.object is None or context.object.type not in ("ARMATURE", "MESH"):
                self.report({"ERROR"}, str(problem))
                return {"CANCELLED"}
            self.report({"WARNING"}, str(problem))
            bone_table.fill(self.bones, preset_file.read(self.name).roles, {})
            return context.window_manager.invoke_props_dialog(self, width=420)
        return self.execute(context)

    def run(self, context):
        rig = writable(rig_of_context(context))
        preset = preset_file.read(self.name)
        body = bone_table.recognised(self.bones, rig, preset.roles, preset.creature)
        skins = skins_to_fit(rig) if self.fit_skin else []
        shapes = populate(rig, preset, body, skins, self.strands, FIGURES[self.figure])
        left_out = placement.left_out(preset, body)
        for part, names in left_out.items():
            self.report({"INFO"}, f"{rig.name} has no {part}: {len(names)} tissues were left out ({names[0]}, ...)")
        dropped = placement.not_placed(preset, body, shapes)
        if dropped:
            why = placement.why_not_placed(preset)
            self.report({"WARNING"}, f"{len(dropped)} muscles were left out, because {why}: {', '.join(dropped)}")
        other = creature.warning(rig, body, self.name, preset.creature, kind.kind_of_character(rig))
        if other:
            self.report({"WARNING"}, other)
        muscles = sum(shape.kind == "MUSCLE" for shape in shapes)
        added = f"{muscles} muscles and {len(shapes) - muscles} other tissues added to {rig.name} ({body.scheme})"
        number = len({name for names in left_out.values() for name in names})
        return f"{added}; {number} tissues left out (no {', no '.join(left_out)})" if number else added

    def draw(self, context):
        layout = self.layout
        layout.use_property_split = True
        layout.prop(self, "name")
        layout.prop(self, "fit_skin")
        if self.fit_skin:
            layout.prop(self, "figure")
        layout.prop(self, "strands")
        bone_table.draw(layout, self.bones, rig_of_context(context))
