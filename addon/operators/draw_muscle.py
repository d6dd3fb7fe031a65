# SPDX-License-Identifier: GPL-3.0-or-later
"""`sinew.draw_muscle` adds a muscle by clicks on the body: the origin, the insertion, and then the width of the belly."""

import bpy
import gpu
from bpy.props import FloatProperty, FloatVectorProperty, StringProperty
from bpy.types import Operator
from bpy_extras import view3d_utils
from gpu_extras.batch import batch_for_shader
from mathutils import Vector

from ..errors import SinewError
from ..languages.messages import translated
from ..muscles import edit, mirror, portable_names, reshape
from ..muscles.placing.place import drawn
from ..scene import bone_geometry, selection, surface_hit, tissue_empty
from ..scene.linked_data import writable
from . import view_geometry
from .base import SinewOperator, rig_of_context

HELP = (
    "Click where the muscle starts",
    "Click where the muscle ends · Esc: cancel",
    "Move: width · Wheel: position of the belly · Click, Enter: confirm · Esc: cancel",
)
COLOUR = (1.0, 0.35, 0.03, 0.9)
WIDTH_PX = 3.0
WHEEL = {"WHEELUPMOUSE": 0.05, "WHEELDOWNMOUSE": -0.05}


class SINEW_OT_draw_muscle(SinewOperator, Operator):
    """Draw a muscle on the body: click its origin, click its insertion, then move the mouse for its width"""

    bl_idname, bl_label = "sinew.draw_muscle", "Draw Muscle"

    origin: FloatVectorProperty(name="Origin", description="Point on the body, in world space", subtype="TRANSLATION")
    insertion: FloatVectorProperty(name="Insertion", description="Point on the body, in world space", subtype="TRANSLATION")
    origin_bone: StringProperty(name="Origin Bone", description="The bone of the origin. Empty: the nearest one")
    insertion_bone: StringProperty(name="Insertion Bone", description="The bone of the insertion. Empty: the nearest one")
    width: FloatProperty(
        name="Width", description="Half the width of the belly. 0: by its length", min=0.0, soft_max=0.2, subtype="DISTANCE"
    )
    belly: FloatProperty(
        name="Belly", description="0: the belly is at the origin, 1: at the insertion", min=0.0, max=1.0, default=0.5
    )

    _drawing = None
    _step = 0

    def run(self, context):
        rig = writable(rig_of_context(context))
        ends = tuple(
            self._attachment(rig, bone, Vector(point))
            for bone, point in ((self.origin_bone, self.origin), (self.insertion_bone, self.insertion))
        )
        shape = reshape.with_belly_at(drawn.shape(rig, ends, self.width), self.belly)
        (empty,) = edit.add(rig, [_with_free_name(rig, shape)])
        if mirror.is_wanted(rig):
            problems: dict[str, str] = {}
            mirror.mirror(rig, [empty], problems)
            self.warn(problems)
        selection.select(empty)
        return f"Added {empty.name} from {shape.origin_bone} to {shape.insertion_bone}"

    def invoke(self, context, event):
        if context.area is None or context.area.type != "VIEW_3D":
            return self.execute(context)
        self._step, self._mouse = 0, Vector((event.mouse_region_x, event.mouse_region_y))
        self.width, self.belly = 0.0, 0.5
        self._rig_name = rig_of_context(context).name
        context.window_manager.modal_handler_add(self)
        if event.type == "LEFTMOUSE" and event.value in ("PRESS", "CLICK"):
            self._click(context)  # the click that started the tool is the origin
        context.workspace.status_text_set(translated(HELP[self._step]))
        self._drawing = bpy.types.SpaceView3D.draw_handler_add(self._draw, (context.region,), "WINDOW", "POST_PIXEL")
        return {"RUNNING_MODAL"}

    def modal(self, context, event):
        if context.area is None or self._rig_name not in context.view_layer.objects:
            return self._end(context, {"CANCELLED"})
        context.area.tag_redraw()
        if event.type in ("ESC", "RIGHTMOUSE"):
            return self._end(context, {"CANCELLED"})
        if event.type == "MOUSEMOVE":
            self._mouse = Vector((event.mouse_region_x, event.mouse_region_y))
            if self._step == 2:
                self.width = self._width(context)
            return {"RUNNING_MODAL"}
        if event.type in WHEEL and self._step == 2:
            self.belly = self.belly + WHEEL[event.type]
            return {"RUNNING_MODAL"}
        is_click = event.type == "LEFTMOUSE" and event.value == "PRESS"
        if not is_click and event.type not in ("RET", "NUMPAD_ENTER"):
            return {"PASS_THROUGH"} if event.type == "MIDDLEMOUSE" or event.type in WHEEL else {"RUNNING_MODAL"}
        if self._step == 2:
            self._end(context, set())
            return self.execute(context)
        self._click(context)
        context.workspace.status_text_set(translated(HELP[self._step]))
        return {"RUNNING_MODAL"}

    def cancel(self, context):
        """Blender calls this when the window closes."""
        self._end(context, set())

    def _click(self, context):
        rig = context.view_layer.objects[self._rig_name]
        region, view = view_geometry.view_of(context)
        start = view3d_utils.region_2d_to_origin_3d(region, view, self._mouse)
        hit = surface_hit.first_hit(context, rig, start, view3d_utils.region_2d_to_vector_3d(region, view, self._mouse))
        if hit is None:
            self.report({"WARNING"}, f"There is no skin of {rig.name} under the mouse. Click on the body")
        elif self._step == 0:
            self.origin, self.origin_bone, self._step = hit.point, hit.bone, 1
        elif hit.bone and hit.bone == self.origin_bone:
            self.report({"WARNING"}, f"Both ends are on '{hit.bone}'. Click on the other side of a joint")
        else:
            self.insertion, self.insertion_bone, self._step = hit.point, hit.bone, 2

    def _width(self, context) -> float:
        """The distance of the mouse from the line between both ends, in the depth of its middle."""
        ends = Vector(self.origin), Vector(self.insertion)
        middle = (ends[0] + ends[1]) / 2
        across = view_geometry.under_mouse(context, self._mouse, middle) - middle
        direction = (ends[1] - ends[0]).normalized()
        return max((across - direction * across.dot(direction)).length, reshape.NARROWEST_M)

    def _end(self, context, result: set) -> set:
        if self._drawing is not None:
            bpy.types.SpaceView3D.draw_handler_remove(self._drawing, "WINDOW")
            self._drawing = None
        if context.workspace:
            context.workspace.status_text_set(None)
        return result

    def _attachment(self, rig, bone: str, point: Vector) -> tuple[str, Vector]:
        """(bone, attachment at rest in armature space) for a point on the body in world space, in the pose."""
        posed = rig.matrix_world.inverted_safe() @ point
        bone = bone or nearest_bone(rig, posed)
        if not bone_geometry.has_bone(rig, bone):
            raise SinewError(f"{rig.name} has no bone '{bone}'")
        return bone, drawn.under_skin(rig, bone, reshape.to_pose(rig, bone).inverted() @ posed)

    def _draw(self, drawn_region):
        region = bpy.context.region
        if region != drawn_region or self._step == 0:
            return
        view = bpy.context.region_data
        start = view3d_utils.location_3d_to_region_2d(region, view, self.origin)
        end = self._mouse if self._step == 1 else view3d_utils.location_3d_to_region_2d(region, view, self.insertion)
        if start is None or end is None:
            return
        lines = [start, end]
        if self._step == 2:
            lines += [(start + end) / 2, self._mouse]
        shader = gpu.shader.from_builtin("POLYLINE_UNIFORM_COLOR")
        shader.bind()
        shader.uniform_float("viewportSize", (region.width, region.height))
        shader.uniform_float("lineWidth", WIDTH_PX)
        shader.uniform_float("color", COLOUR)
        gpu.state.blend_set("ALPHA")
        batch_for_shader(shader, "LINES", {"pos": [(*point, 0.0) for point in lines]}).draw(shader)
        gpu.state.blend_set("NONE")


def nearest_bone(rig, point: Vector) -> str:
    """The deform bone whose posed line is nearest to a point in armature space. Raises SinewError if there is no bone."""

    def distance(bone) -> float:
        along = bone.tail - bone.head
        fraction = min(max((point - bone.head).dot(along) / max(along.length_squared, 1e-12), 0.0), 1.0)
        return (point - bone.head - fraction * along).length

    bones = [bone for bone in rig.pose.bones if rig.data.bones[bone.name].use_deform] or list(rig.pose.bones)
    if not bones:
        raise SinewError(f"{rig.name} has no bones. A muscle needs two")
    return min(bones, key=distance).name


def _with_free_name(rig, shape: tissue_empty.TissueShape) -> tissue_empty.TissueShape:
    """The shape with a name that no tissue of the rig has, because a muscle of the same name would be replaced."""
    name, number = shape.name, 1
    while portable_names.find(rig, name) is not None:
        number += 1
        name = f"{shape.name} {number}"
    return reshape.replace(shape, name=name)
