# SPDX-License-Identifier: GPL-3.0-or-later
"""`sinew.measure`"""

import math

import bpy
from bpy.props import BoolProperty, EnumProperty, FloatProperty, IntProperty, StringProperty
from bpy.types import Operator

from ..display import strain_colours
from ..errors import SinewError
from ..measure import report
from ..measure.measurement import Measurement, Settings
from ..skin.main_skin import main_skin_of
from .base import rig_of_context
from .frame_range import FrameRangeOperator

POSES = (
    ("CURRENT", "Current Pose", "The pose that is shown now"),
    ("FRAMES", "Frames", "The poses of a range of frames"),
    ("JOINTS", "Each Joint", "Each joint by itself, turned from the rest pose"),
)
BONES = (
    ("CROSSED", "All that Muscles Cross", "The joint at the head of each bone that a muscle pulls against its parent"),
    ("SELECTED", "Selected Bones", "The joints at the heads of the bones that are selected in Pose Mode"),
)
AXES = (
    (
        "MUSCLES",
        "as Muscles Turn It",
        "About the axis of the muscles' moments there; the bone's own X where no muscle crosses",
    ),
    ("X", "Bone's X", "About the bone's local X axis"),
    ("Y", "Bone's Y (Twist)", "About the bone itself"),
    ("Z", "Bone's Z", "About the bone's local Z axis"),
)


class SINEW_OT_measure(FrameRangeOperator, Operator):
    """Measure volume, stretch, inverted faces and self-hits of the active mesh under Sinew and Blender's own deformers"""

    bl_idname, bl_label = "sinew.measure", "Measure Quality"

    poses: EnumProperty(name="Poses", items=POSES, default="JOINTS")
    step: IntProperty(name="Step", description="Measure every frame (1), every second (2), ...", default=1, min=1)
    bones: EnumProperty(name="Joints", items=BONES, default="CROSSED")
    axis: EnumProperty(name="Bend", items=AXES, default="MUSCLES")
    angle: FloatProperty(
        name="Up To",
        description="How far each joint is turned from the rest pose; both ways, but a hinge that is bent at rest only further",
        subtype="ANGLE",
        default=math.radians(90.0),
        min=math.radians(1.0),
        max=math.radians(179.0),
    )
    angle_steps: IntProperty(name="Steps", description="In how many steps", default=3, min=1, max=180)
    heat_map: BoolProperty(
        name="Heat Map",
        description=f"Paint the mesh by its stretch in the worst pose, as a colour attribute; {strain_colours.SCALE}",
        default=False,
    )
    json: BoolProperty(name="JSON", description="Keep all numbers as a second text, for programs", default=False)
    filepath: StringProperty(
        name="File", description="Also write all numbers to this file, as JSON", subtype="FILE_PATH", options={"SKIP_SAVE"}
    )

    work_name = "Measuring"
    _measurement = None

    def draw(self, _context):
        layout = self.layout
        layout.use_property_split = True
        layout.prop(self, "poses")
        if self.poses == "FRAMES":
            for name in ("frame_start", "frame_end", "step"):
                layout.prop(self, name)
        elif self.poses == "JOINTS":
            for name in ("bones", "axis", "angle", "angle_steps"):
                layout.prop(self, name)
        layout.prop(self, "heat_map")
        layout.prop(self, "json")
        layout.prop(self, "filepath")

    def begin(self, context):
        self._measurement = Measurement(self._skin(context), context.scene, self._settings(context))
        return self._measurement.steps()

    def abandon(self):
        self._measurement.end()

    def finish(self, _context):
        """Keeps what was found in the file, and tells the worst of it."""
        found = self._measurement
        found.end()
        if self.filepath:
            report.write_file(self.filepath, report.json_of(found))
        skin = bpy.data.objects[found.skin]
        own = skin.sinew
        own.quality_text = report.write_text(f"Quality of {found.skin}", own.quality_text, report.text_of(found))
        if self.json:
            name = f"Quality of {found.skin}.json"
            own.quality_json = report.write_text(name, own.quality_json, report.json_of(found))
        summary = report.summary_of(found)
        own.quality_summary = "\n".join(summary)
        if skin.data.library is None:
            strain_colours.remove(skin.data)
            if self.heat_map:
                strain_colours.show(skin.data, found.stretch(found.worst().pose))
        self.report({"INFO"}, f"{summary[0]}. {summary[1]}. All of it: text '{own.quality_text.name}'")
        return {"FINISHED"}

    def _skin(self, context):
        active = context.object
        if active.type == "MESH":
            return active
        skin = main_skin_of(rig_of_context(context))
        if skin is None:
            raise SinewError(f"{rig_of_context(context).name} has no mesh to measure: select one")
        return skin

    def _settings(self, context) -> Settings:
        bones = None
        if self.poses == "JOINTS" and self.bones == "SELECTED":
            bones = [bone.name for bone in context.selected_pose_bones or ()]
            if not bones:
                raise SinewError("No bones are selected: select some in Pose Mode, or measure all joints that muscles cross")
        return Settings(
            poses=self.poses,
            frames=range(self.frame_start, self.frame_end + 1, self.step),
            bones=bones,
            degrees=math.degrees(self.angle),
            steps=self.angle_steps,
            axis=self.axis,
        )
