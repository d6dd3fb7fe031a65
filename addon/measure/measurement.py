# SPDX-License-Identifier: GPL-3.0-or-later
"""A measurement: poses a skin, measures it under each deformer, and restores the scene.

The measures and the comparison are described in docs/mathematics/quality.md.
"""

from collections.abc import Callable, Generator, Iterator
from dataclasses import dataclass

import bpy
import _sinew
import numpy as np

from ..errors import SinewError
from ..scene import armature_modifier, characters, mesh_arrays, rest_body, rig_pose
from ..scene.current_frame import visit_frames
from ..scene.lookup import objects_named
from . import joint_regions
from .deformers import Deformers, SinewDeformer, transformed

WHOLE = "whole skin"
BENT_FROM_DEGREES = 10.0  # in an animation, joints with a smaller rotation are not measured


@dataclass(frozen=True)
class Settings:
    """The poses to measure.

    poses: "CURRENT"; "FRAMES", the frames of `frames`; or "JOINTS": each joint of `bones`, or each joint that muscles cross,
    is rotated alone from the rest pose, in `steps` steps up to `degrees`, about `axis` (see `joint_regions.joints_of`).
    """

    poses: str
    frames: range
    bones: list[str] | None
    degrees: float
    steps: int
    axis: str


@dataclass(frozen=True)
class Row:
    """The quality of one region under one deformer in one pose."""

    pose: str
    region: str
    deformer: str
    quality: "_sinew.SkinQuality"


class Measurement:
    """A measurement of one skin. Iterate over `steps`, then call `end` in any case to restore the scene."""

    def __init__(self, skin, scene, settings: Settings):
        """Raises SinewError if the skin can't be measured."""
        rig = check_measurable(skin, settings)
        self.skin, self.rig, self.scene, self.settings = skin.name, rig.name, scene, settings
        self.rows: list[Row] = []
        self._stretch: dict[str, np.ndarray] = {}
        self._running: Generator[float] | None = None
        tissues = characters.tissues_of(rig)
        self._sinew = SinewDeformer(skin, rig, tissues) if armature_modifier.is_bound(skin) else None
        musculature = self._sinew.rig_state.musculature if self._sinew else None
        rest = self._sinew.rig_state.rest if self._sinew else _read_rest(skin, rig)
        self._joints = joint_regions.joints_of(skin, rig, rest, musculature, settings.bones, settings.axis)
        if settings.poses == "JOINTS" and not self._joints:
            raise SinewError(
                f"{rig.name} has no joint to measure: no muscle crosses one. Select bones and choose Selected Bones"
            )
        self._deformers = Deformers(scene, skin, rig, posed_freely=settings.poses == "JOINTS")
        try:
            self._read_surface(skin, rig)
        except Exception:
            self.end()
            raise

    def _read_surface(self, skin, rig):
        """Reads the skin in the rest pose, and its regions around joints."""
        rest = transformed(rest_body.read_points(skin), self._deformers.to_metres())
        triangles = rest_body.shown_only(mesh_arrays.read_triangles(skin.data), rest_body.shown_vertices(skin))
        try:
            self._surface = _sinew.RestSurface(rest, triangles)
        except ValueError as error:
            raise SinewError(f"{skin.name}: {error}") from error
        self._whole = self._surface.whole()
        size = rig.matrix_world.median_scale
        regions = {
            joint.bone: self._surface.region(tuple(joint.centre * size), joint.radius * size, joint.vertices)
            for joint in self._joints
        }
        self._regions = {bone: region for bone, region in regions.items() if region}
        if self.settings.poses == "JOINTS" and not self._regions:
            raise SinewError(f"{skin.name} has no skin near {', '.join(regions)} with weights of these bones")

    def steps(self) -> Iterator[float]:
        """Measures one pose per step and yields the progress, 0..1. Raises SinewError."""
        self._running = self._run()
        return self._running

    def _run(self) -> Generator[float]:
        with visit_frames(self.scene) as go_to:
            poses = list(self._poses(go_to))
            for done, (label, enter, regions) in enumerate(poses, 1):
                enter()
                bpy.context.view_layer.update()
                try:
                    self._measure(label, regions)
                except ValueError as error:
                    raise SinewError(f"{self.skin} in pose {label}: {error}") from error
                yield done / len(poses)

    def end(self):
        """Removes the temporary objects and restores the frame."""
        self._deformers.remove()
        if self._running:
            self._running.close()

    def worst(self) -> Row:
        """The worst row of the first deformer, which is Sinew if the mesh is bound.

        It has the most inverted faces and new self-intersections; of several such rows, the largest change of volume.
        """
        first = self.rows[0].deformer

        def faults(row: Row):
            return row.quality.inverted + row.quality.new_intersections, abs(row.quality.union - 1.0)

        return max((row for row in self.rows if row.deformer == first), key=faults)

    def stretch(self, pose: str) -> np.ndarray:
        """(vertices,) float32: the stretch of each vertex in a pose, under the first deformer."""
        return self._stretch[pose]

    def _poses(self, go_to: Callable[[float], None]):
        """(label, function that sets the pose, joints to measure) of each pose. Joints None: those that are bent."""
        match self.settings.poses:
            case "CURRENT":
                yield f"frame {self.scene.frame_current}", lambda: None, None
            case "FRAMES":
                for frame in self.settings.frames:
                    yield f"frame {frame}", lambda frame=frame: go_to(frame), None
            case "JOINTS":
                for joint in self._joints:
                    if joint.bone not in self._regions:
                        continue
                    for degrees in self._angles(joint):
                        label = f"{joint.bone} {degrees:+.0f}°"
                        yield label, lambda joint=joint, degrees=degrees: self._rotate(joint, degrees), [joint.bone]

    def _angles(self, joint: joint_regions.Joint) -> list[float]:
        angles = [self.settings.degrees * step / self.settings.steps for step in range(1, self.settings.steps + 1)]
        return angles if joint.bends_one_way else [*(-angle for angle in reversed(angles)), *angles]

    def _rotate(self, joint: joint_regions.Joint, degrees: float):
        rig = self._deformers.free_rig
        for bone in rig.pose.bones:
            bone.matrix_basis.identity()
        joint_regions.rotate(rig, joint, degrees)

    def _measure(self, pose: str, regions: list[str] | None):
        if regions is None:
            (rig,) = objects_named([self.rig], "measure again")
            evaluated = rig.evaluated_get(bpy.context.evaluated_depsgraph_get())
            angles = {name: joint_regions.rotation_degrees(rig, evaluated, name) for name in self._regions}
            regions = [name for name, degrees in angles.items() if degrees > BENT_FROM_DEGREES]
        for index, (deformer, points) in enumerate(self._deformers.points(self._sinew).items()):
            if not np.isfinite(points).all():
                raise SinewError(f"{self.skin} is not finite under {deformer} in pose {pose}. Check its bones' scales")
            deformed = self._surface.deformed(points)
            for region in regions:
                self.rows.append(Row(pose, region, deformer, deformed.quality(self._regions[region])))
            self.rows.append(Row(pose, WHOLE, deformer, deformed.quality(self._whole)))
            if index == 0:
                self._stretch[pose] = deformed.vertex_stretch


def check_measurable(skin, settings: Settings):
    """The rig of a mesh that can be measured. Raises SinewError for other meshes; the message says what to do."""
    if skin.type != "MESH":
        raise SinewError(f"{skin.name} is a {skin.type.lower()}, not a mesh. Select the character's mesh")
    if skin.library:
        raise SinewError(
            f"{skin.name} is linked from another file and can't store the measurement. Make a library override of it"
        )
    if not skin.data.polygons:
        raise SinewError(f"{skin.name} has no faces to measure")
    rig = armature_modifier.rig_of(skin)
    for measured in (skin, rig):
        if measured.data.is_editmode:
            raise SinewError(f"{measured.name} is in Edit Mode. Leave it (Tab) and measure again")
        if abs(measured.matrix_world.determinant()) < 1e-18:
            raise SinewError(f"{measured.name} has a scale of 0. Give it a scale above 0 on all axes")
    if not skin.visible_get():
        raise SinewError(f"{skin.name} is hidden, and Blender does not evaluate it. Show it and measure again")
    if rig.data.pose_position == "REST":
        raise SinewError(f"{rig.name} shows its rest pose. Switch to Pose Position and measure again")
    if armature_modifier.is_bound(skin) and not skin.sinew.skin.live and len(skin.sinew.skin.baked_keys):
        raise SinewError(f"{skin.name} plays baked keys. Switch Live on and measure again")
    if settings.poses == "FRAMES" and not settings.frames:
        raise SinewError(f"The last frame ({settings.frames.stop - 1}) is before the first ({settings.frames.start})")
    return rig


def _read_rest(skin, rig) -> rig_pose.RigRest:
    try:
        return rig_pose.read_rest(rig)
    except ValueError as error:
        raise SinewError(f"{skin.name}: {error}") from error
