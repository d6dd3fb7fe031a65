# SPDX-License-Identifier: GPL-3.0-or-later
"""Viewport geometry of the Reach tool: bone ends near the mouse, and goals in world space.

Mouse positions are in pixels of the viewport's main region. `view` is its `RegionView3D`.
"""

from bpy_extras.view3d_utils import location_3d_to_region_2d, region_2d_to_location_3d
from mathutils import Vector

PICK_WITHIN_PX = 40.0
PREFERRED_BY_PX = 1.0
FAR_OF_DISTANCE = 10.0
DEPTH_OF_VIEW = 0.015
SNAP_OF_UNIT = 0.05
AXES = {"X": Vector((1, 0, 0)), "Y": Vector((0, 1, 0)), "Z": Vector((0, 0, 1))}


def view_of(context):
    """(region, view) of the viewport, also if the operator was started from its sidebar."""
    region = next(region for region in context.area.regions if region.type == "WINDOW")
    return region, context.area.spaces.active.region_3d


def is_over_scene(area, event) -> bool:
    """Whether the mouse is over the scene and not over a sidebar, a header or another editor."""
    over = [
        region.type
        for region in area.regions
        if 0 <= event.mouse_x - region.x < region.width and 0 <= event.mouse_y - region.y < region.height
    ]
    return over == ["WINDOW"]


def is_hidden(bone) -> bool:
    """Whether a pose bone is hidden. Blender 5 hides the pose bone, Blender 4.5 the bone of the armature."""
    return bone.hide if hasattr(bone, "hide") else bone.bone.hide


def bone_near(context, rig, mouse: Vector, at_tail: bool, preferred: str) -> str | None:
    """The visible bone whose end is nearest to the mouse; None if no end is near.

    preferred: the bone that is chosen among ends at nearly the same pixel.
    """
    region, view = view_of(context)
    distances_px = {}
    for bone in rig.pose.bones:
        if is_hidden(bone):
            continue
        end_px = location_3d_to_region_2d(region, view, rig.matrix_world @ (bone.tail if at_tail else bone.head))
        if end_px is not None:
            distances_px[bone.name] = (end_px - mouse).length - (PREFERRED_BY_PX if bone.name == preferred else 0.0)
    nearest = min(distances_px, key=distances_px.get, default=None)
    return nearest if nearest is not None and distances_px[nearest] <= PICK_WITHIN_PX else None


def under_mouse(context, mouse: Vector, depth: Vector) -> Vector:
    """The point under the mouse, at the depth of another point."""
    return region_2d_to_location_3d(*view_of(context), mouse, depth)


def far_goal(context, mouse: Vector, end: Vector) -> Vector:
    """A distant goal in the direction from a bone's end to the mouse, so that the chain points there."""
    return end + FAR_OF_DISTANCE * (under_mouse(context, mouse, end) - end)


def depth_step(context) -> Vector:
    """The displacement away from the viewer by one step of the mouse wheel."""
    view = view_of(context)[1]
    return view.view_rotation @ Vector((0, 0, -1)) * (DEPTH_OF_VIEW * view.view_distance)


def on_axis(goal: Vector, start: Vector, axis: str) -> Vector:
    """The point nearest to a goal on the line through `start` along a world axis."""
    direction = AXES[axis]
    return start + direction * direction.dot(goal - start)


def on_grid(goal: Vector) -> Vector:
    """The grid point nearest to a goal."""
    return Vector(SNAP_OF_UNIT * round(coordinate / SNAP_OF_UNIT) for coordinate in goal)
