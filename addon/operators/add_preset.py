# SPDX-License-Identifier: GPL-3.0-or-later
"""`sinew.add_preset` adds the musculature of a preset to an armature."""

from bpy.props import CollectionProperty, EnumProperty, StringProperty
from bpy.types import Operator, PropertyGroup

from ..errors import SinewError
from ..muscles.placing.place import placement, preset_file
from ..muscles.placing.place.preset_to_rig import populate
from ..muscles.placing.recognise import creature, segments
from ..muscles.placing.recognise.body import Body
from ..muscles.placing.recognise.body_parts import CENTRAL_ROLES, ROLES, body_parts, part_label
from ..scene.linked_data import writable
from ..skin.main_skin import skins_to_fit
from .base import SinewOperator, rig_of_context
from .tissue_options import FIT_SKIN

CENTRE = "C"
STRANDS = (
    (placement.SEPARATE, "Separate", "Build one muscle per strand"),
    (placement.JOINED, "Joined", "Join strands of one muscle that run side by side"),
)


def _preset_items(_self, _context):
    return preset_file.available()  # the same list in every call, because Blender keeps no reference to its strings


class SinewSegmentBone(PropertyGroup):
    """The first bone of a part of the body. Its name is the label in the list."""

    role: EnumProperty(
        name="Part",
        description="The part of the body",
        items=[(role, part_label(role).capitalize(), f"The {part_label(role)}") for role in ROLES],
    )
    side: EnumProperty(
        name="Side",
        description="The side of the body",
        items=[(CENTRE, "Center", "On the center line"), ("L", "Left", "The left side"), ("R", "Right", "The right side")],
        default=CENTRE,
    )
    bone: StringProperty(name="Bone", description="The first bone of this part, nearest to the center of the body")

    @property
    def part(self) -> tuple[str, str]:
        """(role, side), as in `segments`."""
        return self.role, "" if self.role in CENTRAL_ROLES else self.side


class SINEW_OT_add_preset(SinewOperator, Operator):
    """Add the muscles of a preset to the armature and fit them under its mesh. Muscles with the same names are replaced"""

    bl_idname, bl_label = "sinew.add_preset", "Add Preset"

    name: EnumProperty(name="Preset", description="The preset whose muscles are added", items=_preset_items)
    fit_skin: FIT_SKIN
    strands: EnumProperty(
        name="Strands", description="How to build muscles that the preset stores as several strands", items=STRANDS
    )
    bones: CollectionProperty(
        type=SinewSegmentBone,
        name="Bones",
        description="The first bone of each part of the body. Recognized bones are filled in and can be corrected",
        options={"SKIP_SAVE"},
    )

    def invoke(self, context, _event):
        """Opens a dialog for the bones if they are not recognised."""
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
        rig = writable(rig_of_context(context))
        preset = preset_file.read(self.name)
        body = self._recognised(rig, preset)
        shapes = populate(rig, preset, body, skins_to_fit(rig) if self.fit_skin else [], self.strands)
        left_out = placement.left_out(preset, body)
        for part, names in left_out.items():
            self.report({"INFO"}, f"{rig.name} has no {part}: {len(names)} tissues were left out ({names[0]}, ...)")
        short = placement.without_length(preset, body, shapes)
        if short:
            where = f"their ends are at the same point of {rig.name}"
            self.report({"WARNING"}, f"{len(short)} muscles were left out, because {where}: {', '.join(short)}")
        not_human = creature.warning(rig, body, self.name, preset.roles)
        if not_human:
            self.report({"WARNING"}, not_human)
        muscles = sum(shape.kind == "MUSCLE" for shape in shapes)
        added = f"{muscles} muscles and {len(shapes) - muscles} other tissues added to {rig.name} ({body.scheme})"
        number = len({name for names in left_out.values() for name in names})
        return f"{added}; {number} tissues left out (no {', no '.join(left_out)})" if number else added

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
            role, side = row.part
            column.prop_search(row, "bone", rig.data, "bones", text=part_label(role, side).capitalize())

    def _recognised(self, rig, preset) -> Body:
        body = segments.recognise(rig, {row.part: row.bone for row in self.bones})
        self._fill(preset, {part: bones[0] for part, bones in body.recognised.chains.items()})
        return body

    def _fill(self, preset, guesses):
        """Adds the missing rows: every part that was recognised or that the preset needs."""
        present = {row.part for row in self.bones}
        for role, side in body_parts():
            if (role, side) not in present and ((role, side) in guesses or role in preset.roles):
                row = self.bones.add()
                row.role, row.side = role, side or CENTRE
                row.name, row.bone = part_label(role, side), guesses.get((role, side), "")
