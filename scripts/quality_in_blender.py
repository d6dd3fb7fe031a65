"""The measuring inside Blender: poses one joint at a time and prints a table.

usage: scripts/run_in_blender.py scripts/quality_in_blender.py PRESET
"""

import math
import sys

import body_in_blender
import bpy
import demo_motion
import numpy as np
from demo_measures import points_of
from demo_scene import make_active
from mathutils.bvhtree import BVHTree

POSES = (("elbow.L", 90), ("elbow.L", 120), ("elbow.L", 150), ("knee.L", 90), ("knee.L", 140), ("hip.L", 90), ("hip.L", 110))
# the limb around a joint: bones whose skin belongs to it, and its radius as a share of the limb below
LIMBS = {
    "elbow.L": (("upperarm01.L", "upperarm02.L", "lowerarm01.L", "lowerarm02.L"), ("lowerarm01.L", "wrist.L")),
    "knee.L": (("upperleg01.L", "upperleg02.L", "lowerleg01.L", "lowerleg02.L"), ("lowerleg01.L", "foot.L")),
    "hip.L": (("root", "pelvis.L", "upperleg01.L", "upperleg02.L"), ("upperleg01.L", "lowerleg01.L")),
}
MODES = ("Armature modifier", "Sinew", "Sinew, elastic")


class Region:
    """The skin around a joint, closed over its rims, to measure its volume."""

    def __init__(self, skin, rig, joint: str, triangles: np.ndarray, rest: np.ndarray):
        bones, (start, end) = LIMBS[joint]
        centre = np.array(rig.data.bones[start].head_local)
        radius = 0.5 * np.linalg.norm(np.array(rig.data.bones[end].head_local) - centre)
        groups = {skin.vertex_groups[name].index for name in bones}
        share = np.array([sum(e.weight for e in v.groups if e.group in groups) for v in skin.data.vertices])
        near = np.linalg.norm(rest[triangles].mean(axis=1) - centre, axis=1) < radius
        self.triangles = triangles[near & (share[triangles] > 0.5).all(axis=1)]
        edges = np.concatenate([self.triangles[:, pair] for pair in ([0, 1], [1, 2], [2, 0])])
        present = set(map(tuple, edges.tolist()))
        self.rims = _loops([(a, b) for a, b in present if (b, a) not in present])

    def volume(self, points: np.ndarray) -> float:
        """Signed volume, closing each rim by a fan over its mean, m^3."""
        points = points.astype(np.float64) - points[self.triangles.ravel()].mean(axis=0)
        a, b, c = (points[self.triangles[:, corner]] for corner in range(3))
        total = np.einsum("ij,ij->", a, np.cross(b, c))
        for rim in self.rims:
            starts, ends = points[[edge[0] for edge in rim]], points[[edge[1] for edge in rim]]
            total += np.einsum("ij,ij->", ends, np.cross(starts, starts.mean(axis=0)[None]))
        return float(total / 6.0)


def _loops(edges: list) -> list:
    after = dict(edges)
    loops = []
    while after:
        start, end = next(iter(after.items()))
        loop = []
        while start in after:
            end = after.pop(start)
            loop.append((start, end))
            start = end
        loops.append(loop)
    return loops


def cuts(points: np.ndarray, triangles: np.ndarray) -> set:
    """The pairs of triangles without a common vertex that cut each other."""
    tree = BVHTree.FromPolygons(points.tolist(), triangles.tolist(), all_triangles=True)
    return {
        (a, b) for a, b in tree.overlap(tree) if a < b and not set(triangles[a].tolist()) & set(triangles[b].tolist())
    }


def pose(rig, joint: str, degrees: float):
    hinge = demo_motion.hinge(rig, joint)
    bone = rig.pose.bones[hinge.bone]
    own = bone.bone.matrix_local.to_3x3()
    bone.matrix_basis = (own.inverted() @ hinge.turn(math.radians(degrees)) @ own).to_4x4()
    bpy.context.view_layer.update()
    return bone


def main(preset: str) -> None:
    bpy.ops.wm.read_factory_settings(use_empty=True)
    skin, rig = body_in_blender.build()
    skin.data.calc_loop_triangles()
    triangles = np.array([triangle.vertices for triangle in skin.data.loop_triangles])
    rest = points_of(skin)
    cuts_at_rest = cuts(rest, triangles)
    make_active(rig)
    bpy.ops.sinew.add_preset(name=preset)
    make_active(skin)
    bpy.ops.sinew.bind()
    print(f"{'':16}" + "".join(f"{mode:>24}" for mode in MODES))
    for joint, degrees in POSES:
        region = Region(skin, rig, joint, triangles, rest)
        bone = pose(rig, joint, degrees)
        cells = []
        for mode in MODES:
            skin.sinew.live = mode != MODES[0]
            skin.sinew.elastic = mode == MODES[2]
            bpy.context.view_layer.update()
            points = points_of(skin)
            share = region.volume(points) / region.volume(rest)
            cells.append(f"{share:.3f}, {len(cuts(points, triangles) - cuts_at_rest)} cuts")
        print(f"{joint.split('.')[0]:>8} {degrees:3d}°   " + "".join(f"{cell:>24}" for cell in cells), flush=True)
        bone.matrix_basis.identity()
    print("volume around the joint against rest, new pairs of triangles that cut each other")


if __name__ == "__main__":
    main(sys.argv[1])
