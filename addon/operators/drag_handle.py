# SPDX-License-Identifier: GPL-3.0-or-later
"""`sinew.drag_handle` moves one handle of a muscle: its origin, its insertion, a via point, or a width of its belly.

A script gives the position; in the viewport, the handle follows the mouse until the button is released.
"""

from bpy.props import BoolProperty, FloatVectorProperty, StringProperty
from bpy.types import Operator
from bpy_extras import view3d_utils
from mathutils import Vector

from ..errors import SinewError
from ..languages.messages import translated
from ..muscles import mirror, reshape
from ..muscles.placing.fit import fit
from ..muscles.placing.fit.skin_surface import SkinSurface
from ..scene import surface_hit, tissue_empty
from ..skin.main_skin import main_skin_of
from . import view_geometry
from .base import MuscleOperator, writable_muscle

HELP = "Drag: slide around the bone · Ctrl: snap to the skin · Shift: move freely · Release: confirm · Esc: cancel"
SHORTEST_ON_SCREEN = 0.4  # of a unit axis: below, a small movement of the mouse would be a large one of the handle


class SINEW_OT_drag_handle(MuscleOperator, Operator):
    """Move a handle of the active muscle. It slides around its bone; Ctrl snaps it to the skin, Shift moves it freely"""

    bl_idname, bl_label = "sinew.drag_handle", "Move Muscle Handle"

    handle: StringProperty(
        name="Handle",
        description="ORIGIN, INSERTION, WIDTH_X, WIDTH_Y, or VIA 0, VIA 1, ... for via points",
        default=reshape.ORIGIN,
    )
    position: FloatVectorProperty(
        name="Position", description="The new position of the handle, in world space", subtype="TRANSLATION"
    )
    refit: BoolProperty(
        name="Fit under Skin", description="Resize the muscle so that it ends just under the skin again", default=False
    )

    _name = ""
    _shape = None

    def run(self, context):
        muscle = writable_muscle(context)
        shape = self._shape or tissue_empty.read(muscle, muscle.parent)
        self._shape = None
        shape = reshape.moved(shape, self.handle, self._at_rest(muscle.parent, shape, Vector(self.position)))
        skin = main_skin_of(muscle.parent) if self.refit else None
        if skin is not None:
            shape = fit.fit(shape, SkinSurface.of(skin, muscle.parent))
        tissue_empty.write(muscle, shape)
        if mirror.is_wanted(muscle.parent):
            mirror.write_twin(muscle.parent, muscle)
        return f"{muscle.name} changed"

    def invoke(self, context, _event):
        if context.area is None or context.area.type != "VIEW_3D":
            return self.execute(context)
        try:
            muscle = writable_muscle(context)
            self._shape = tissue_empty.read(muscle, muscle.parent)
            self._start = self._in_world(muscle.parent, self._shape, reshape.handles_of(self._shape)[self.handle])
        except (SinewError, KeyError) as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        self._name, self.position = muscle.name, self._start
        self.refit = not self.handle.startswith("WIDTH")
        context.window_manager.modal_handler_add(self)
        context.workspace.status_text_set(translated(HELP))
        return {"RUNNING_MODAL"}

    def modal(self, context, event):
        muscle = context.view_layer.objects.get(self._name)
        if muscle is None or context.area is None:
            return self._end(context, {"CANCELLED"})
        if event.type in ("ESC", "RIGHTMOUSE"):
            tissue_empty.write(muscle, self._shape)
            return self._end(context, {"CANCELLED"})
        if event.type == "MOUSEMOVE":
            self.position = self._under_mouse(context, muscle, event)
            try:
                shape = reshape.moved(self._shape, self.handle, self._at_rest(muscle.parent, self._shape, self.position))
                tissue_empty.write(muscle, shape)
            except SinewError:
                pass  # the mouse is over the other end; the next movement leaves it
            return {"RUNNING_MODAL"}
        if event.type == "LEFTMOUSE" and event.value == "RELEASE":
            self._end(context, set())
            return self.execute(context)
        return {"RUNNING_MODAL"}

    def cancel(self, context):
        """Restores the muscle. Blender calls this when the window closes."""
        muscle = context.view_layer.objects.get(self._name)
        if muscle is not None and self._shape is not None:
            tissue_empty.write(muscle, self._shape)

    def _end(self, context, result: set) -> set:
        if context.workspace:
            context.workspace.status_text_set(None)
        return result

    def _under_mouse(self, context, muscle, event) -> Vector:
        rig = muscle.parent
        mouse = Vector((event.mouse_region_x, event.mouse_region_y))
        if event.ctrl:
            region, view = view_geometry.view_of(context)
            start = view3d_utils.region_2d_to_origin_3d(region, view, mouse)
            hit = surface_hit.first_hit(context, rig, start, view3d_utils.region_2d_to_vector_3d(region, view, mouse))
            if hit is not None:
                return hit.point
        free = view_geometry.under_mouse(context, mouse, self._start)
        if self.handle.startswith("WIDTH"):
            return self._on_width_axis(context, rig, free)
        if event.shift:
            return free
        bone = reshape.bone_of_handle(self._shape, self.handle)
        before = reshape.handles_of(self._shape)[self.handle]
        distance = reshape.distance_to_bone(rig, bone, before)
        return self._in_world(rig, self._shape, reshape.on_bone(rig, bone, self._at_rest(rig, self._shape, free), distance))

    def _on_width_axis(self, context, rig, free: Vector) -> Vector:
        """The point on the axis of a width that the mouse wants. free: the point under the mouse, in the handle's depth.

        An axis that points at the viewer has no direction on the screen; there, up is wider.
        """
        centre = self._in_world(rig, self._shape, self._shape.centre)
        axis = (self._start - centre).normalized()
        rotation = view_geometry.view_of(context)[1].view_rotation
        ahead = rotation @ Vector((0, 0, -1))
        on_screen = axis - ahead * axis.dot(ahead)
        if on_screen.length < SHORTEST_ON_SCREEN:
            change = (free - self._start).dot(rotation @ Vector((0, 1, 0)))
        else:
            change = (free - self._start).dot(on_screen) / on_screen.length_squared
        width = (self._start - centre).length + change
        return centre + axis * max(width, reshape.NARROWEST_M)

    def _at_rest(self, rig, shape, point: Vector) -> Vector:
        """A point in world space, in the pose, as a point at rest in armature space."""
        bone = reshape.bone_of_handle(shape, self.handle)
        return reshape.to_pose(rig, bone).inverted() @ (rig.matrix_world.inverted_safe() @ Vector(point))

    def _in_world(self, rig, shape, point: Vector) -> Vector:
        """A point at rest in armature space, as a point in world space, in the pose."""
        return rig.matrix_world @ (reshape.to_pose(rig, reshape.bone_of_handle(shape, self.handle)) @ point)
