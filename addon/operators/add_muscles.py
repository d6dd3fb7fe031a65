# SPDX-License-Identifier: GPL-3.0-or-later
"""`sinew.add_muscles` adds the muscles that fit the kind of creature: a preset, or automatic muscles at each joint."""

from bpy.props import EnumProperty
from bpy.types import Operator

from ..errors import SinewError
from ..muscles import edit
from ..muscles.placing.place import automatic, placement, preset_file
from ..muscles.placing.place.figure import FIGURES
from ..muscles.placing.place.preset_to_rig import populate
from ..muscles.placing.recognise import choice
from ..muscles.placing.recognise import kind as kinds
from ..scene import characters, skinned_bones
from ..scene.linked_data import writable
from ..skin.main_skin import skins_to_fit
from . import bone_table
from .base import SinewOperator, rig_of_context
from .tissue_options import FIGURE, FIT_SKIN

BY_KIND = "AUTO"
LIKELY = 0.5  # below this sureness the report asks to check the kind
FEWEST_OF_PRESET = 0.25  # of its tissues: a body that lacks more of the preset's parts gets muscles at all of its joints
CREATURES = (
    (BY_KIND, "Automatic", "Recognize the kind of creature by its bones and its mesh"),
    ("human", "Human", "The preset Human"),
    ("quadruped", "Four-Legged Animal", "The preset Quadruped"),
    ("bird", "Bird", "The preset Bird"),
    ("fish", "Fish", "The preset Fish"),
    ("arthropod", "Insect or Spider", "Muscles at each joint"),
    ("other", "Other", "Muscles at each joint"),
)


class SINEW_OT_add_muscles(SinewOperator, Operator):
    """Recognize the creature and add its muscles, or muscles at each joint. Muscles of the same names are replaced"""

    bl_idname, bl_label = "sinew.add_muscles", "Add Muscles"

    creature: EnumProperty(name="Creature", description="The kind of creature, which chooses the muscles", items=CREATURES)
    fit_skin: FIT_SKIN
    figure: FIGURE
    bones: bone_table.bones_property()

    def run(self, context):
        rig = writable(rig_of_context(context))
        skinned = skinned_bones.skinned_bones(rig, characters.skins_of(rig))
        found = None
        if self.creature == BY_KIND:
            found = kinds.kind_of(rig, skinned, kinds.object_names(rig))
        kind = found.name if found else self.creature
        looks = f"{rig.name} looks like {found.text}" if found else f"{rig.name} is treated as {kinds.LABELS[kind]}"
        if found and found.sureness < LIKELY:
            self.report({"WARNING"}, f"{looks}. Choose the creature in this operator (F9) if that is wrong")
        preset = choice.preset_of(kind)
        if preset:
            try:
                return f"{looks}. {self._from_preset(rig, preset_file.read(preset))}"
            except SinewError as problem:
                self.report({"WARNING"}, f"The preset {preset} can't be used, so the joints get muscles instead: {problem}")
        return f"{looks}. {self._on_joints(rig, skinned)}"

    def _from_preset(self, rig, preset: preset_file.Preset) -> str:
        body = bone_table.recognised(self.bones, rig, preset.roles, preset.creature)
        placement.require(preset, body)
        left_out = placement.left_out(preset, body)
        number = len({name for names in left_out.values() for name in names})
        whole = sum(len(rule.sides) for rule in preset.tissues)
        if self.creature == BY_KIND and whole - number < FEWEST_OF_PRESET * whole:
            raise SinewError(f"{rig.name} has parts for only {whole - number} of its {whole} tissues")
        skins = skins_to_fit(rig) if self.fit_skin else []
        shapes = populate(rig, preset, body, skins, figure=FIGURES[self.figure])
        muscles = sum(shape.kind == "MUSCLE" for shape in shapes)
        added = f"{muscles} muscles and {len(shapes) - muscles} other tissues added ({preset.name}, {body.scheme})"
        dropped = len(placement.not_placed(preset, body, shapes))
        reasons = [f"no {part}" for part in left_out]
        reasons += [f"{dropped} because {placement.why_not_placed(preset)}"] if dropped else []
        return f"{added}; {number + dropped} tissues left out ({', '.join(reasons)})" if reasons else added

    def _on_joints(self, rig, skinned: skinned_bones.SkinnedBones) -> str:
        options = automatic.Options(fit_skin=self.fit_skin)
        shapes, joints = automatic.on_joints(rig, None, skins_to_fit(rig), skinned, options)
        if not shapes:
            raise SinewError(
                f"{rig.name}: no joint can hold muscles. Muscles need two bones, one below the other, that carry skin and "
                "are not fingers or parts of a face; Add Muscles to Joints adds them to any selected bones"
            )
        edit.add(rig, shapes)
        return f"{len(shapes)} muscles added to {joints} joints"

    def draw(self, context):
        layout = self.layout
        layout.use_property_split = True
        layout.prop(self, "creature")
        layout.prop(self, "fit_skin")
        if self.fit_skin:
            layout.prop(self, "figure")
        if self.bones:
            bone_table.draw(layout, self.bones, rig_of_context(context))
