# SPDX-License-Identifier: GPL-3.0-or-later
"""`sinew.add_preset`"""

import time

from bpy.props import BoolProperty, CollectionProperty, EnumProperty, StringProperty
from bpy.types import Operator, PropertyGroup

from ..errors import SinewError
from ..muscles.placing.place import placement, preset_file
from ..muscles.placing.place.population import populate
from ..muscles.placing.recognise import segments
from ..muscles.placing.recognise.naming import CENTRAL_ROLES, ROLES, SIDES, in_words, places
from ..scene.linked_data import writable
from ..skin.main_skin import main_skin_of
from .base import SinewOperator, rig_of_context

CENTRE = "C"
STRANDS = (
    (placement.SEPARATE, "Separate", "Each strand of a fan is a muscle of its own"),
    (placement.JOINED, "Joined", "Strands of one muscle that run side by side are one belly"),
)


def _preset_items(_self, _context):
    return preset_file.available()  # the same list at every call: Blender keeps no reference to an enumeration's texts


class SinewSegmentBone(PropertyGroup):
    """Which bone a part of the body begins with; the name is what the list shows."""

    role: EnumProperty(name="Part", items=[(role, in_words(role).capitalize(), "") for role in ROLES])
    side: EnumProperty(name="Side", items=[(CENTRE, "Centre", ""), *((side, side, "") for side in SIDES)], default=CENTRE)
    bone: StringProperty(name="Bone", description="The first bone of this part, the one nearest to the body's middle")

    @property
    def place(self) -> tuple[str, str]:
        """(role, side) as `segments` has it."""
        return self.role, "" if self.role in CENTRAL_ROLES else self.side


class SINEW_OT_add_preset(SinewOperator, Operator):
    """Add a whole set of muscles to the armature, sized to lie under its mesh; muscles of the same names are replaced"""

    bl_idname, bl_label = "sinew.add_preset", "Add Muscles"

    name: EnumProperty(name="Preset", description="Which set of muscles", items=_preset_items)
    fit_skin: BoolProperty(
        name="Fit under Skin", description="Size the muscles so that they lie under the mesh", default=True
    )
    strands: EnumProperty(name="Strands", description="What becomes of muscles told strand by strand", items=STRANDS)
    bones: CollectionProperty(
        type=SinewSegmentBone,
        name="Bones",
        description="Which bone each part of the body begins with: filled with a guess, to be corrected",
        options={"SKIP_SAVE"},
    )

    def invoke(self, context, _event):
        """Asks for the bones where the guess doesn't do."""
        try:
            rig, preset = rig_of_context(context), preset_file.read(self.name)
            body = self._recognised(rig, preset)
            placement.require(preset, body)
        except SinewError as problem:
            if context.object is None or context.object.type not in ("ARMATURE", "MESH"):
                self.report({"ERROR"}, str(problem))
                return {"CANCELLED"}
            self.report({"WARNING"}, str(problem))
            self._fill(preset_file.read(self.name), {})
            return context.window_manager.invoke_props_dialog(self, width=420)
        return self.execute(context)

    def run(self, context):
        began_s = time.perf_counter()
        rig = writable(rig_of_context(context))
        preset = preset_file.read(self.name)
        body = self._recognised(rig, preset)
        shapes = populate(rig, preset, body, main_skin_of(rig) if self.fit_skin else None, self.strands)
        for part, names in placement.left_out(preset, body).items():
            self.report({"INFO"}, f"{rig.name} has no {part}: {len(names)} tissues left out ({names[0]}, ...)")
        muscles = sum(shape.kind == "MUSCLE" for shape in shapes)
        took_s = time.perf_counter() - began_s
        return (
            f"{muscles} muscles and {len(shapes) - muscles} other tissues added to {rig.name} ({body.scheme}) "
            f"in {took_s:.2f} s"
        )

    def draw(self, context):
        layout = self.layout
        layout.use_property_split = True
        layout.prop(self, "name")
        layout.prop(self, "fit_skin")
        layout.prop(self, "strands")
        rig = rig_of_context(context)
        column = layout.column(align=True)
        column.label(text="Bones")
        for row in self.bones:
            role, side = row.place
            column.prop_search(row, "bone", rig.data, "bones", text=in_words(role, side).capitalize())

    def _recognised(self, rig, preset) -> segments.Body:
        body = segments.recognise(rig, {row.place: row.bone for row in self.bones})
        self._fill(preset, {place: bones[0] for place, bones in body.recognised.chains.items()})
        return body

    def _fill(self, preset, guesses):
        """Adds the rows that the table lacks: every part that was found or that the preset needs."""
        present = {row.place for row in self.bones}
        for place in places():
            if place not in present and (place in guesses or place[0] in preset.roles):
                row = self.bones.add()
                row.role, row.side = place[0], place[1] or CENTRE
                row.name, row.bone = in_words(*place), guesses.get(place, "")
