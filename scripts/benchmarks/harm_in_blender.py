"""Sweeps the joints of characters and compares each pose with the Armature modifier alone; see scripts/harm.py.

usage: scripts/run_in_blender.py scripts/benchmarks/harm_in_blender.py OPTIONS, a JSON object
"""

import json
import math
import random
import sys
from dataclasses import dataclass
from pathlib import Path

import bpy
import _sinew
import numpy as np
from mathutils import Matrix

from benchmarks.recognition_table import load

BLENDERS_OWN = ("corrective_smooth", "preserve_volume")
AXES = (("X", 1), ("X", -1), ("Z", 1), ("Z", -1), ("Y", 1))
LEAST_SHARE = 0.003  # of all weights: a bone with less carries no skin
SHORTEST_OF_SIZE = 1e-4  # edges up to this fraction of the mesh's size have no stretch
BENT, STRETCHED = 1.001, 1.02  # stretch of an edge from which its faces count as bent, and from which it counts itself
HEADER = (
    "| character | poses | worse | inverted faces | intersections | stretch |\n"
    "|---|---|---|---|---|---|"
)  # fmt: skip


@dataclass
class Faults:
    """Faults of a character in a pose, summed over its meshes; the stretch is that of the worst mesh."""

    inverted: int = 0
    intersections: int = 0
    stretch: float = 1.0

    def is_worse_than(self, other: "Faults") -> bool:
        def is_more(ours: int, theirs: int, least: int) -> bool:
            return ours > theirs + max(least, 0.05 * theirs)

        return (
            is_more(self.inverted, other.inverted, 1)
            or is_more(self.intersections, other.intersections, 2)
            or self.stretch > 1.1 * other.stretch + 0.05
        )


@dataclass(frozen=True)
class Turn:
    """A rotation of a joint about an axis of its bone."""

    joint: str
    axis: str
    degrees: float


class Skin:
    """A mesh, and a copy of it under the Armature modifier alone."""

    def __init__(self, mesh):
        self.mesh = mesh
        self.alone = mesh.copy()
        self.alone.data = mesh.data.copy()
        bpy.context.scene.collection.objects.link(self.alone)

    def measure_rest(self) -> None:
        """Reads the rest pose; all bones are at rest."""
        data = self.alone.data
        data.calc_loop_triangles()
        self.triangles = np.empty((len(data.loop_triangles), 3), np.int32)
        data.loop_triangles.foreach_get("vertices", self.triangles.reshape(-1))
        self.rest = positions(self.alone)
        self.surface = _sinew.RestSurface(self.rest, self.triangles)
        ends = np.sort(np.concatenate([self.triangles[:, [0, 1]], self.triangles[:, [1, 2]], self.triangles[:, [2, 0]]]), 1)
        edges = np.unique(ends, axis=0)
        lengths = self.lengths(self.rest, edges)
        is_long = lengths > SHORTEST_OF_SIZE * np.ptp(self.rest, axis=0).max()
        self.edges, self.rest_lengths = edges[is_long], lengths[is_long]

    @staticmethod
    def lengths(points: np.ndarray, edges: np.ndarray) -> np.ndarray:
        return np.linalg.norm(points[edges[:, 0]].astype(float) - points[edges[:, 1]], axis=1)

    def add_faults(self, mesh, total: Faults) -> None:
        posed = positions(mesh)
        ratio = np.maximum(self.lengths(posed, self.edges), 1e-12) / self.rest_lengths
        stretch = np.maximum(ratio, 1 / ratio)
        is_bent = np.zeros(len(posed), bool)
        is_bent[self.edges[stretch > BENT].ravel()] = True
        deformed = self.surface.deformed(posed)
        total.inverted += int((deformed.inverted & is_bent[self.triangles].any(1)).sum())
        total.intersections += len(deformed.new_intersections)
        stretched = stretch[stretch > STRETCHED]
        if len(stretched):
            total.stretch = max(total.stretch, float(np.percentile(stretched, 99)))


def positions(mesh) -> np.ndarray:
    """(V, 3) float32: the evaluated vertices in world space."""
    evaluated = mesh.evaluated_get(bpy.context.evaluated_depsgraph_get())
    data = evaluated.to_mesh()
    points = np.empty((len(data.vertices), 3), np.float32)
    data.vertices.foreach_get("co", points.reshape(-1))
    matrix = np.array(evaluated.matrix_world)
    evaluated.to_mesh_clear()
    return np.ascontiguousarray(points @ matrix[:3, :3].T + matrix[:3, 3], np.float32)


def meshes_of(rig) -> list:
    """The meshes that the rig deforms, the largest first."""

    def is_deformed(found) -> bool:
        return found.type == "MESH" and any(
            modifier.type == "ARMATURE" and modifier.object == rig for modifier in found.modifiers
        )

    found = [mesh for mesh in bpy.context.view_layer.objects if is_deformed(mesh) and len(mesh.data.polygons)]
    return sorted(found, key=lambda mesh: -len(mesh.data.vertices))


def put_at_rest(rig) -> None:
    if rig.animation_data:
        rig.animation_data_clear()
    for bone in rig.pose.bones:
        bone.matrix_basis = Matrix()
        for constraint in bone.constraints:
            constraint.mute = True
    bpy.context.view_layer.update()


def joints_of(rig, meshes: list, most: int) -> list[str]:
    """The bones that carry skin and have an ancestor that does; those with most skin first."""
    share = dict.fromkeys((bone.name for bone in rig.data.bones), 0.0)
    for mesh in meshes:
        names = [group.name for group in mesh.vertex_groups]
        for group in (group for vertex in mesh.data.vertices for group in vertex.groups):
            if names[group.group] in share:
                share[names[group.group]] += group.weight
    least = LEAST_SHARE * sum(len(mesh.data.vertices) for mesh in meshes)
    carries = {bone for bone, weight in share.items() if weight > least}
    joints = [
        bone.name
        for bone in rig.data.bones
        if bone.name in carries and any(above.name in carries for above in bone.parent_recursive)
    ]
    return sorted(joints, key=lambda name: -share[name])[:most]


def poses_of(joints: list[str], angles: list[float], pairs: int) -> list[tuple[Turn, ...]]:
    """Each joint by itself, about each axis and by each angle; then `pairs` poses of two joints at once."""
    turns = {joint: [Turn(joint, axis, sign * degrees) for degrees in angles for axis, sign in AXES] for joint in joints}
    chosen = random.Random(0)
    both = [chosen.sample(joints, 2) for _ in range(pairs if len(joints) > 1 else 0)]
    return [
        *((turn,) for joint in joints for turn in turns[joint]),
        *(tuple(chosen.choice(turns[joint]) for joint in pair) for pair in both),
    ]


def make_active(item) -> None:
    if bpy.context.mode != "OBJECT":
        bpy.ops.object.mode_set(mode="OBJECT")
    for other in bpy.context.view_layer.objects:
        other.select_set(False)
    item.hide_set(False)
    item.select_set(True)
    bpy.context.view_layer.objects.active = item


def deform(rig, meshes: list, muscles: str) -> None:
    """Adds Sinew's muscles and binds, or adds Blender's own deformer.

    Raises RuntimeError with the operator's report if it refuses.
    """
    for mesh in meshes if muscles in BLENDERS_OWN else ():
        if muscles == "preserve_volume":
            next(modifier for modifier in mesh.modifiers if modifier.type == "ARMATURE").use_deform_preserve_volume = True
        else:
            smooth = mesh.modifiers.new("Smooth", "CORRECTIVE_SMOOTH")
            smooth.rest_source, smooth.iterations = "ORCO", 5
    if muscles in BLENDERS_OWN:
        return
    make_active(rig)
    if muscles == "auto":
        bpy.ops.sinew.add_automatic()
    else:
        bpy.ops.sinew.add_preset(name=muscles)
    for mesh in meshes:
        make_active(mesh)
        bpy.ops.sinew.bind()


def sweep(path: Path, options: dict) -> int:
    """Sweeps one character and prints its row; returns the number of poses that are worse."""
    rig = load(path)
    if rig is None:
        print(f"| {path.name} | 0 | | no skinned mesh | | |")
        return 0
    put_at_rest(rig)
    meshes = meshes_of(rig)
    skins = [Skin(mesh) for mesh in meshes]
    try:
        deform(rig, meshes, options["muscles"])
    except RuntimeError as error:
        print(f"| {path.name} | 0 | | refused: {' '.join(str(error).split())} | | |")
        return 0
    return sweep_joints(path.name, rig, meshes, skins, options)


def sweep_joints(name: str, rig, meshes: list, skins: list[Skin], options: dict) -> int:
    """Rotates the joints one after another and prints the row of a character; returns the number of worse poses."""
    bpy.context.view_layer.update()
    for skin in skins:
        skin.measure_rest()
    totals, poses, worse = (Faults(), Faults()), 0, []
    stretches = ([], [])
    for turns in poses_of(joints_of(rig, meshes, options["joints"]), options["degrees"], options["pairs"]):
        for turn in turns:
            rig.pose.bones[turn.joint].matrix_basis = Matrix.Rotation(math.radians(turn.degrees), 4, turn.axis)
        bpy.context.view_layer.update()
        alone, ours = Faults(), Faults()
        for skin in skins:
            skin.add_faults(skin.alone, alone)
            skin.add_faults(skin.mesh, ours)
        for total, found, stretch in zip(totals, (alone, ours), stretches, strict=True):
            total.inverted += found.inverted
            total.intersections += found.intersections
            stretch.append(found.stretch)
        poses += 1
        if ours.is_worse_than(alone):
            pose = ", ".join(f"{turn.joint} {turn.axis} {turn.degrees:g}" for turn in turns)
            worse.append(f"  {pose}: {alone} alone, {ours} with Sinew")
        for turn in turns:
            rig.pose.bones[turn.joint].matrix_basis = Matrix()
    (alone, ours), (before, after) = totals, (np.mean(stretch) if stretch else 1.0 for stretch in stretches)
    print(
        f"| {name} | {poses} | {len(worse)} | {alone.inverted} → {ours.inverted} | "
        f"{alone.intersections} → {ours.intersections} | {before:.2f} → {after:.2f} |",
        *(worse if options["worse"] else ()), sep="\n", flush=True,
    )  # fmt: skip
    return len(worse)


def main() -> int:
    options = json.loads(sys.argv[1])
    print(HEADER, flush=True)
    return int(sum(sweep(Path(file), options) for file in options["files"]) > 0)


if __name__ == "__main__":
    sys.exit(main())
