"""The real body under Blender's deformers and Sinew at once, in one pose, and the skin around its joints.

Each deformer has its own mesh on the same rig.
"""

import bpy
import _sinew
import numpy as np
from data import body_in_blender
from demos.measures import points_of
from demos.scene import make_active

from benchmarks import quality_poses

LINEAR, PRESERVE_VOLUME, SMOOTH, SINEW = "linear", "Preserve Volume", "Corrective Smooth", "Sinew"
BLENDERS_OWN = (LINEAR, PRESERVE_VOLUME, SMOOTH)
SMOOTH_ITERATIONS = 5
WEIGHING = 0.01


class Character:
    """The body with its muscles, and optionally a copy of its mesh under each of Blender's deformers."""

    def __init__(self, preset: str, iterations: int | None):
        bpy.ops.wm.read_factory_settings(use_empty=True)
        self.skin, self.rig = body_in_blender.build()
        make_active(self.rig)
        bpy.ops.sinew.add_preset(name=preset)
        make_active(self.skin)
        self.skin.sinew.skin.elastic = True
        if iterations is not None:
            self.skin.sinew.skin.iterations = iterations
        bpy.ops.sinew.bind()
        self.rest = points_of(self.skin)
        self.triangles = triangles_of(self.skin.data)
        self.surface = _sinew.RestSurface(self.rest, self.triangles)
        self.whole = self.surface.whole()
        self._weights = [{element.group: element.weight for element in vertex.groups} for vertex in self.skin.data.vertices]
        self._regions: dict[str, _sinew.SurfaceRegion] = {}
        self.shown = {SINEW: self.skin}

    def add_blenders_own(self) -> None:
        """Adds a copy of the mesh under each of Blender's deformers."""
        self.shown = {name: self._plain(name) for name in BLENDERS_OWN} | self.shown
        bpy.context.view_layer.update()

    def _plain(self, name: str):
        """A copy of the mesh under one of Blender's deformers."""
        shown = bpy.data.objects.new(name, self.skin.data.copy())
        bpy.context.scene.collection.objects.link(shown)
        shown.parent = self.rig
        modifier = shown.modifiers.new("Armature", "ARMATURE")
        modifier.object, modifier.use_deform_preserve_volume = self.rig, name == PRESERVE_VOLUME
        if name == SMOOTH:
            smooth = shown.modifiers.new("Smooth", "CORRECTIVE_SMOOTH")
            smooth.rest_source, smooth.iterations = "ORCO", SMOOTH_ITERATIONS
        return shown

    def pose(self, degrees: dict[str, float], makes_fists: bool = False) -> None:
        """Sets a pose, in degrees by joint. All other joints are at rest."""
        for bone in self.rig.pose.bones:
            bone.matrix_basis.identity()
        for name, rotation in quality_poses.rotations_of(self.rig, degrees, makes_fists).items():
            bone = self.rig.pose.bones[name]
            rest = bone.bone.matrix_local.to_3x3()
            bone.matrix_basis = (rest.inverted() @ rotation @ rest).to_4x4()
        bpy.context.view_layer.update()

    def points(self, deformer: str) -> np.ndarray:
        """(vertices, 3) float32: the skin of this deformer in the current pose."""
        return points_of(self.shown[deformer])

    def region(self, joint: str) -> "_sinew.SurfaceRegion":
        """The skin around a joint such as `elbow.L`."""
        if joint not in self._regions:
            hinge = quality_poses.hinge_of(self.rig, joint)
            bone = self.rig.data.bones[hinge.bone]
            near = [bone, bone.parent, *bone.children_recursive]
            radius = quality_poses.radius_of(self.rig, joint)
            carried = self.weight_of([bone.name for bone in near]) > WEIGHING
            self._regions[joint] = self.surface.region(tuple(bone.head_local), radius, carried)
        return self._regions[joint]

    def weight_of(self, bones: list[str]) -> np.ndarray:
        """(vertices,): for each vertex, the largest of the weights of some bones."""
        groups = {self.skin.vertex_groups[name].index for name in bones if name in self.skin.vertex_groups}
        return np.array(
            [max((weights[group] for group in weights.keys() & groups), default=0.0) for weights in self._weights]
        )

    def weight_below(self, bone: str) -> np.ndarray:
        """(vertices,): for each vertex, the sum of the weights of a bone and of all bones below it."""
        names = [bone, *(below.name for below in self.rig.data.bones[bone].children_recursive)]
        groups = {self.skin.vertex_groups[name].index for name in names if name in self.skin.vertex_groups}
        return np.array([sum(weights[group] for group in weights.keys() & groups) for weights in self._weights])


def triangles_of(mesh) -> np.ndarray:
    """(triangles, 3) int32: each quad is divided from its first corner to its third."""
    quads = np.empty((len(mesh.polygons), 4), np.int32)
    mesh.polygons.foreach_get("vertices", quads.reshape(-1))
    return np.ascontiguousarray(np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]]))
