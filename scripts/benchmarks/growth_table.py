"""Measures growing a skin over Rigify's cat: the time by resolution, and the quality of four reductions to 3,000 faces.

usage: python3 scripts/run_in_blender.py scripts/benchmarks/growth_table.py [--rounds N]

The first table compares with Blender's Voxel Remesh of the same ellipsoids. Times are the shortest of several rounds, which
is the time on an idle machine.
"""

import argparse
import math
import time

import bpy
import _sinew
import addon_utils
import bmesh
import numpy as np
from bl_ext.user_default.sinew.live import session
from bl_ext.user_default.sinew.scene import characters, rig_pose
from mathutils import Matrix
from mathutils.bvhtree import BVHTree
from mathutils.kdtree import KDTree

RESOLUTIONS = (83, 128, 256, 512)
FACES = 3000
SLIVER = 0.2


class Cat:
    """Rigify's cat with the preset, and the musculature over which its skin grows."""

    def __init__(self):
        bpy.ops.wm.read_factory_settings(use_empty=True)
        addon_utils.enable("rigify", default_set=True)
        bpy.ops.object.armature_cat_metarig_add()
        self.rig = bpy.context.object
        bpy.ops.sinew.add_preset(name="cat")
        self.state = session.rig_state(self.rig, characters.tissues_of(self.rig), bpy.context.evaluated_depsgraph_get())

    def grown(self, **options) -> _sinew.GrownSkin:
        rest, count = self.state.rest, len(self.state.musculature)
        weight_bones = np.arange(len(rest.skeleton), dtype=np.int32)
        return _sinew.GrownSkin(self.state.musculature, np.zeros(count, np.float32), rest.lengths, weight_bones, **options)

    def balls(self) -> bpy.types.Mesh:
        """All ellipsoids as one mesh of spheres."""
        musculature, rest = self.state.musculature, self.state.rest
        pose = np.empty_like(self.state.pose)
        rig_pose.read_pose(self.rig.evaluated_get(bpy.context.evaluated_depsgraph_get()), rest, pose)
        matrices = np.empty((musculature.ellipsoid_count, 4, 4), np.float32)
        musculature.pose_ellipsoids(pose, np.zeros(len(musculature), np.float32), matrices)
        made = bmesh.new()
        for matrix in matrices:
            bmesh.ops.create_uvsphere(made, u_segments=24, v_segments=16, radius=1.0, matrix=Matrix(matrix.T.tolist()))
        mesh = bpy.data.meshes.new("Balls")
        made.to_mesh(mesh)
        return mesh


def shortest(work, rounds: int):
    """(seconds, result) of the fastest round."""
    times = []
    for _ in range(rounds):
        began_s = time.perf_counter()
        result = work()
        times.append(time.perf_counter() - began_s)
    return min(times), result


def object_of(mesh) -> bpy.types.Object:
    """A new object of a mesh. It is active and the only selected object."""
    made = bpy.data.objects.new(mesh.name, mesh)
    bpy.context.scene.collection.objects.link(made)
    for found in bpy.context.view_layer.objects:
        found.select_set(found == made)
    bpy.context.view_layer.objects.active = made
    return made


def mesh_of(skin: _sinew.GrownSkin) -> bpy.types.Mesh:
    mesh = bpy.data.meshes.new("Skin")
    mesh.from_pydata(skin.points.tolist(), [], skin.quads.tolist())
    return mesh


def voxel_remeshed(balls, resolution: int, rounds: int):
    size = max(np.ptp(np.array([vertex.co for vertex in balls.vertices]), axis=0))

    def work():
        made = object_of(balls.copy())
        made.data.remesh_voxel_size = float(size) / resolution
        bpy.ops.object.voxel_remesh()
        return made

    return shortest(work, rounds)


def pieces_of(mesh) -> int:
    made = bmesh.new()
    made.from_mesh(mesh)
    left, count = set(made.verts), 0
    while left:
        count += 1
        open_ = [left.pop()]
        while open_:
            around = {edge.other_vert(vertex) for vertex in (open_.pop(),) for edge in vertex.link_edges} & left
            left -= around
            open_ += around
    return count


def print_times(cat: Cat, rounds: int) -> None:
    balls = cat.balls()
    print("| resolution | vertices | Sinew | pieces | Voxel Remesh | its vertices | pieces |\n|---|---|---|---|---|---|---|")
    for resolution in RESOLUTIONS:
        sinew_s, skin = shortest(lambda size=resolution: cat.grown(resolution=size), rounds)
        remesh_s, remeshed = voxel_remeshed(balls, resolution, rounds)
        print(
            f"| {resolution} | {len(skin):,} | {sinew_s:.2f} s | {skin.pieces} | {remesh_s:.2f} s | "
            f"{len(remeshed.data.vertices):,} | {pieces_of(remeshed.data)} |",
            flush=True,
        )


def quality_of(a, b, c) -> float:
    """4 sqrt(3) times the area, divided by the sum of squared edge lengths: 1 for an equilateral triangle."""
    squares = (b - a).length_squared + (c - b).length_squared + (a - c).length_squared
    return 2.0 * math.sqrt(3.0) * (b - a).cross(c - a).length / squares if squares else 0.0


def print_reduced(name: str, mesh, full: _sinew.GrownSkin, took_s: float) -> None:
    made = bmesh.new()
    made.from_mesh(mesh)
    is_manifold = all(part.is_manifold for part in (*made.edges, *made.verts))
    tree, points = BVHTree.FromBMesh(made), KDTree(len(made.verts))
    distances_mm = 1000.0 * np.array([tree.find_nearest(point)[3] for point in full.points.tolist()])
    for index, vertex in enumerate(made.verts):
        points.insert(vertex.co, index)
    points.balance()
    uneven_mm = 1000.0 * max(points.find((-v.co.x, v.co.y, v.co.z))[2] for v in made.verts)
    bmesh.ops.triangulate(made, faces=made.faces[:])
    qualities = [quality_of(*(vertex.co for vertex in face.verts)) for face in made.faces]
    quads = sum(face.loop_total == 4 for face in mesh.polygons)
    print(
        f"| {name} | {len(mesh.polygons):,}, {quads:,} of four corners | {took_s:.2f} s | {distances_mm.mean():.2f}, "
        f"{distances_mm.max():.1f} mm | {uneven_mm:.3f} mm | {min(qualities):.2f}, {sum(q < SLIVER for q in qualities)} | "
        f"{'yes' if is_manifold else 'no'} |",
        flush=True,
    )


def print_reductions(cat: Cat, rounds: int) -> None:
    options = {"resolution": 128, "smoothing": 8, "thickness": 0.003}
    full_s, full = shortest(lambda: cat.grown(**options), rounds)
    print("| | faces | time | off the full surface: mean, most | left and right | worst triangle, slivers | manifold |")
    print("|---|---|---|---|---|---|---|")
    took_s, skin = shortest(lambda: cat.grown(**options, faces=FACES), rounds)
    print_reduced("Faces (coarser lattice)", mesh_of(skin), full, took_s - full_s)
    for name, symmetric in (("Decimate", False), ("Decimate, Symmetry X", True)):
        made = object_of(mesh_of(full))
        modifier = made.modifiers.new("Decimate", "DECIMATE")
        modifier.ratio, modifier.use_symmetry = FACES / len(full.quads), symmetric
        began_s = time.perf_counter()
        evaluated = made.evaluated_get(bpy.context.evaluated_depsgraph_get())
        print_reduced(name, bpy.data.meshes.new_from_object(evaluated), full, time.perf_counter() - began_s)
    made = object_of(mesh_of(full))
    began_s = time.perf_counter()
    bpy.ops.object.quadriflow_remesh(target_faces=FACES, use_mesh_symmetry=True)
    print_reduced("QuadriFlow", made.data, full, time.perf_counter() - began_s)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--rounds", type=int, default=15)
    rounds = parser.parse_args().rounds
    cat = Cat()
    print_times(cat, rounds)
    print()
    print_reductions(cat, rounds)


if __name__ == "__main__":
    main()
