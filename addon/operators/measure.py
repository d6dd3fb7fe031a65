# SPDX-License-Identifier: GPL-3.0-or-later
"""`sinew.measure` measures the quality of a skin (docs/mathematics/quality.md)."""

import math

from bpy.props import BoolProperty, EnumProperty, FloatProperty, IntProperty, StringProperty
from bpy.types import Operator

from ..display import edge_stretch_colours
from ..errors import SinewError
from ..measure import report
from ..measure.measurement import Measurement, Settings
from ..scene.lookup import objects_named
from ..skin.main_skin import main_skin_of
from .base import rig_of_context
from .frame_range import STEP, FrameRangeOperator
from .joint_choices import CROSSED, SELECTED

POSES = (
    ("CURRENT", "Current Pose", "The pose that the viewport shows"),
    ("FRAMES", "Frames", "The poses in a range of frames"),
    ("JOINTS", "Each Joint", "Each joint by itself, rotated from the rest pose"),
)
AXES = (
    (
        "MUSCLES",
        "Muscle Axis",
        "The axis of the muscles' moments at the joint. Without muscles, the bone's local X axis",
    ),
    ("X", "Bone's X", "The bone's local X axis"),
    ("Y", "Bone's Y (Twist)", "The bone's local Y axis, which twists it"),
    ("Z", "Bone's Z", "The bone's local Z axis"),
)


class SINEW_OT_measure(FrameRangeOperator, Operator):
    """Measure volume, stretch, inverted faces and self-intersections of the mesh, compared with Blender's deformers"""

    bl_idname, bl_label = "sinew.measure", "Measure Quality"

    poses: EnumProperty(name="Poses", description="The poses to measure", items=POSES, default="JOINTS")
    step: STEP
    bones: EnumProperty(name="Joints", description="The joints to measure", items=(CROSSED, SELECTED), default="CROSSED")
    axis: EnumProperty(name="Axis", description="The axis that each joint rotates about", items=AXES, default="MUSCLES")
    angle: FloatProperty(
        name="Maximum Angle",
        description="Test each joint up to this angle, in both directions; hinges only in their bending direction",
        subtype="ANGLE",
        default=math.radians(90.0),
        min=math.radians(1.0),
        max=math.radians(179.0),
    )
    angle_steps: IntProperty(name="Steps", description="Number of steps up to the maximum angle", default=3, min=1, max=180)
    heat_map: BoolProperty(
        name="Heat Map",
        description=f"Store the stretch in the worst pose as a color attribute ({edge_stretch_colours.SCALE})",
        default=False,
    )
    json: BoolProperty(name="JSON", description="Also store all numbers as JSON in a second text", default=False)
    filepath: StringProperty(
        name="File", description="Also write all numbers to this JSON file", subtype="FILE_PATH", options={"SKIP_SAVE"}
    )

    work_name = activity = "Measuring"
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
        """Stores the results in the blend file and reports the worst values."""
        measurement = self._measurement
        measurement.end()
        if self.filepath:
            report.write_file(self.filepath, report.json_of(measurement))
        (skin,) = objects_named([measurement.skin], "measure again")
        settings = skin.sinew.skin
        title = f"Quality of {measurement.skin}"
        settings.quality_text = report.write_text(title, settings.quality_text, report.text_of(measurement))
        if self.json:
            settings.quality_json = report.write_text(f"{title}.json", settings.quality_json, report.json_of(measurement))
        summary = report.summary_of(measurement)
        settings.quality_summary = "\n".join(summary)
        if skin.data.library is None:
            edge_stretch_colours.remove(skin.data)
            if self.heat_map:
                edge_stretch_colours.show(skin.data, measurement.stretch(measurement.worst().pose))
        self.report({"INFO"}, f"{summary[0]}. {summary[1]}. Details: text '{settings.quality_text.name}'")
        return {"FINISHED"}

    def _skin(self, context):
        active = context.object
        if active.type == "MESH":
            return active
        skin = main_skin_of(rig_of_context(context))
        if skin is None:
            raise SinewError(f"{rig_of_context(context).name} has no mesh to measure. Select one")
        return skin

    def _settings(self, context) -> Settings:
        bones = None
        if self.poses == "JOINTS" and self.bones == "SELECTED":
            bones = [bone.name for bone in context.selected_pose_bones or ()]
            if not bones:
                raise SinewError(
                    "No bones are selected. Select bones in Pose Mode, or measure all joints that muscles cross"
                )
        return Settings(
            poses=self.poses,
            frames=range(self.frame_start, self.frame_end + 1, self.step),
            bones=bones,
            degrees=math.degrees(self.angle),
            steps=self.angle_steps,
            axis=self.axis,
        )
